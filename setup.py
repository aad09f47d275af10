"""ament_python packaging: `colcon build` in a ROS workspace, `pip install` anywhere else."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'qzs_rig'


def files(folder):
    """Files of a folder, relative to this file as setuptools wants them."""
    return sorted(str(path) for path in Path(folder).iterdir() if path.is_file())


setup(
    name=PACKAGE,
    version='0.2.0',
    description='Virtual test rig for a quasi-zero-stiffness vibration isolation platform',
    license='Apache-2.0',
    maintainer='qzs_rig developers',
    maintainer_email='maintainers@qzs-rig.example.org',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={PACKAGE: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/config', files('config')),
        (f'share/{PACKAGE}/config/campaigns', files('config/campaigns')),
        (f'share/{PACKAGE}/launch', files('launch')),
        (f'share/{PACKAGE}/urdf', files('urdf')),
    ],
    python_requires='>=3.10',
    install_requires=[
        'numpy>=1.24,<3',
        'PyYAML>=6,<7',
        'mcap>=1.2,<2',
        'numba>=0.59,<1',
        'rosbags>=0.10,<0.12',
        'scipy>=1.11,<2',
        'zstandard>=0.21,<1',
        'bokeh>=3.4,<4',
        'threadpoolctl>=3.1,<4',
        'tqdm>=4.60,<5',
    ],
    extras_require={
        'ros': [
            'ros-kilted-rclpy>=9.1,<10',
            'ros-kilted-rmw-fastrtps-cpp>=9.3,<10',
            'ros-kilted-common-interfaces>=5.5,<6',
        ],
        'picture': ['matplotlib>=3.7,<4'],
        'campaign': ['dask>=2024.1,<2028', 'distributed>=2024.1,<2028', 'pyarrow>=15,<30'],
        # what benchmarks hold the theory against
        'peers': ['heyoka>=7,<8', 'harmonicbalance>=0.2,<0.3', 'mousai>=0.3,<0.4'],
        'test': [
            'hypothesis>=6.90,<7',
            'mypy>=1.8,<3',
            'pytest>=8,<10',
            'pytest-repeat>=0.9,<1',
            'ruff>=0.6,<1',
            'selenium>=4.15,<5',
            'types-PyYAML>=6,<7',
            'types-tqdm>=4.60,<5',
            'colcon-core>=0.15,<1',
            'colcon-ros>=0.5,<1',
            'matplotlib>=3.7,<4',
            'dask>=2024.1,<2028',
            'distributed>=2024.1,<2028',
            'pyarrow>=15,<30',
        ],
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'qzs-rig = qzs_rig.cli.main:main',
            'exciter = qzs_rig.ros.exciter:main',
            'platform = qzs_rig.ros.platform:main',
            'analyzer = qzs_rig.ros.analyzer:main',
            'player = qzs_rig.ros.player:main',
        ],
    },
)
