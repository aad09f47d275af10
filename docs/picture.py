"""The picture in the README: the default scenario, measured and predicted (`make docs-picture`)."""

from pathlib import Path

from qzs_rig import scenario
from qzs_rig.prediction.predict import predict
from qzs_rig.report.run_page import write_picture
from qzs_rig.run import in_process


def main() -> None:
    """Perform the default scenario in process and draw it beside this file."""
    spec = scenario.load(scenario.DEFAULT)
    path = Path(__file__).with_name('vertical_sweep.svg')
    path.unlink(missing_ok=True)
    write_picture(path, [('rig', in_process.run(spec).estimate)], theory=predict(spec))
    print(path)


if __name__ == '__main__':
    main()
