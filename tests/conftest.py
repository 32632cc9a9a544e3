"""Options of the whole test suite."""

from __future__ import annotations

import gc
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

# A suite that is started in the background inherits an ignored Ctrl-C, and so does every process it starts; the
# tests that press Ctrl-C would wait for nothing.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

gc.set_threshold(50_000, 20, 20)  # what is loaded is no garbage: a seventh of the time of tests that are Python


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--shared",
        type=Path,
        metavar="FOLDER",
        help="folder with the third-party files that tests/validation/third_party compares with; without it "
        "they are deselected",
    )
    parser.addoption("--slow", action="store_true", help="also tests that take seconds each, as .ci/run does")
    parser.addoption("--long", action="store_true", help="also tests that take minutes each, and the slow ones")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """What runs only when asked for: comparisons with third-party files, which are not ours to ship, slow and long tests."""
    slow, long = config.getoption("--slow"), config.getoption("--long")

    def wanted(item: pytest.Item) -> bool:
        if item.path.parent.name == "third_party" and config.getoption("--shared") is None:
            return False
        if item.get_closest_marker("long"):
            return bool(long)
        return bool(slow or long) or not item.get_closest_marker("slow")

    config.hook.pytest_deselected(items=[item for item in items if not wanted(item)])
    items[:] = [item for item in items if wanted(item)]


ROOT = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def no_stray_file() -> Iterator[None]:
    """What a test writes goes into a folder of its own; the checkout, from which the suite is started, stays as it is."""
    before = set(ROOT.iterdir())
    yield
    stray = {path.name for path in set(ROOT.iterdir()) - before if not path.name.startswith(".")}
    assert stray - {"build"} == set(), "left in the checkout; write below tmp_path"


@pytest.fixture(scope="session")
def shared(request: pytest.FixtureRequest) -> Path:
    """The folder named by --shared."""
    return request.config.getoption("--shared")
