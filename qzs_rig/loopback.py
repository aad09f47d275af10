"""ROS 2 on this machine alone: a domain that nobody else uses, and Fast DDS on 127.0.0.1."""

from __future__ import annotations

import errno
import itertools
import os
import socket
from collections.abc import MutableMapping
from pathlib import Path

from qzs_rig import scenario
from qzs_rig.errors import InputError, PeerError

RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
DOMAIN = 'ROS_DOMAIN_ID'
DOMAINS = range(1, 102)
"""Domain ids whose ports stay below Linux's ephemeral range."""
PORTS = 250
"""UDP ports of a domain (RTPS 2.5, 9.6.2)."""

_turns = itertools.count(os.getpid())


class Domain:
    """A domain id that is this process's own, on this machine, until `close`.

    It is held by the name of a socket, which the kernel gives back however the process ends.
    """

    def __init__(self, number: int, token: socket.socket) -> None:
        self.number = number
        self._token = token

    def close(self) -> None:
        """Let others have it."""
        self._token.close()


def reserve_domain() -> Domain:
    """A domain that no other caller holds and whose ports nobody has bound.

    Raises PeerError where all of DOMAINS are taken.
    """
    bound = _bound_ports()
    for _ in DOMAINS:
        number = DOMAINS[next(_turns) % len(DOMAINS)]
        first = 7400 + PORTS * number
        if bound.isdisjoint(range(first, first + PORTS)):
            token = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            try:
                token.bind(f'\0qzs_rig/domain/{number}')
            except OSError as error:
                token.close()
                if error.errno == errno.EADDRINUSE:  # by somebody who has no ports yet
                    continue
                raise PeerError(
                    f'no ROS domain can be reserved ({error.strerror}); choose one with {DOMAIN}'
                ) from error
            return Domain(number, token)
    raise PeerError(
        f'all ROS domains from {DOMAINS[0]} to {DOMAINS[-1]} are in use on this machine; '
        f'end what uses them, or choose one with {DOMAIN}'
    )


def settle(environment: MutableMapping[str, str]) -> None:
    """Give `environment` the rig's Fast DDS profile where it asks for this machine only.

    ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST alone limits discovery, not sockets, and brings shared
    memory, which a killed process leaves behind. The profile keeps to UDP on 127.0.0.1; it comes
    into force with SYSTEM_DEFAULT, since LOCALHOST would add its own transports. A profile,
    middleware, range or peers of the user's own choice are left alone. To be called before
    rclpy.init. Raises InputError where the profile is not installed.
    """
    chosen = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE', 'ROS_STATIC_PEERS')
    middleware = environment.get('RMW_IMPLEMENTATION') or 'rmw_fastrtps_cpp'
    if (
        environment.get(RANGE) != 'LOCALHOST'
        or any(environment.get(name) for name in chosen)
        or not middleware.startswith('rmw_fastrtps')
    ):
        return
    profile = scenario.config_folder() / 'fastdds.xml'
    if not profile.is_file():
        raise InputError(
            f'{profile} is missing; install qzs_rig again, or name a profile in {chosen[0]}'
        )
    environment.pop('ROS_LOCALHOST_ONLY', None)  # Jazzy's would overrule the range
    # Fast DDS 3 renamed the variable; older releases know the old name only
    old = environment.get('ROS_DISTRO') in ('humble', 'iron', 'jazzy')
    environment[chosen[1] if old else chosen[0]] = str(profile)
    environment[RANGE] = 'SYSTEM_DEFAULT'


def _bound_ports() -> set[int]:
    """UDP ports (IPv4) that are bound on this machine."""
    try:
        rows = Path('/proc/net/udp').read_text(encoding='ascii').splitlines()[1:]
    except OSError:
        return set()
    return {int(row.split()[1].split(':')[1], 16) for row in rows}
