"""How the tests run: on the CPU, in double precision, compiled code kept between runs, the same examples every time."""

import ctypes
import gc
import os
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from hypothesis import settings

os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ.setdefault("JAX_ENABLE_X64", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small dense solves wait for their threads where cores are busy
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")  # XLA calls it an error when it loads code that it compiled itself

# Runs are many small files: in memory they cost a third of the system's time there
IN_MEMORY, ENOUGH = "/dev/shm", 2**30  # bytes
with suppress(OSError):
    if os.access(IN_MEMORY, os.W_OK | os.X_OK) and shutil.disk_usage(IN_MEMORY).free > ENOUGH:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", IN_MEMORY)

# A script that starts pytest in its background has it ignore SIGINT, and nohup SIGHUP; so would all that the tests
# start, because ertel respects that
for number, handler in ((signal.SIGINT, signal.default_int_handler), (getattr(signal, "SIGHUP", None), signal.SIG_DFL)):
    if number is not None and signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, handler)

gc.disable()  # while modules and tests are collected, a quarter of the time; see `pytest_collection_finish`

# Most tests run for less time than their programs take to optimise: a third of the time to compile (measured)
QUICK_TO_COMPILE = (
    "--xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false --xla_llvm_disable_expensive_passes=true "
    "--xla_cpu_parallel_codegen_split_count=1"  # the other core has its own tests
)

# bytes at the end of a test file from which on compiled programs are forgotten; a file adds at most 0.5e9
MOST_MEMORY = 1.1e9
# Each file is one worker's, and the last ones should be short: first what takes longest
LONGEST = ("solvers/", "runs/", "test_documents", "equations/", "apps/test_cli", "numerics/", "results/", "plots/")

# Distinct programs that the quick tests compile, which is most of their work; what needs more of them is slow
MOST_PROGRAMS = 115

settings.register_profile("ertel", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("ertel")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--costs", action="store_true", help="list tests and files by processor time, and the memory")


def pytest_configure(config: pytest.Config) -> None:
    """Keep compiled code in pytest's own cache."""
    cache: pytest.Cache | None = getattr(config, "cache", None)
    if cache is not None:
        config.stash[KEPT] = _programs(cache)
        os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(cache.mkdir("jax")))
        os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
    if "XLA_FLAGS" not in os.environ and config.getoption("markexpr") == "not slow" and _xla_knows(QUICK_TO_COMPILE):
        os.environ["XLA_FLAGS"] = QUICK_TO_COMPILE  # also of worker processes and of those that tests start
    os.fsync = lambda handle: None  # no test cuts the power: waiting for the disk takes a tenth of the time
    # coarse grids are what makes tests quick
    config.addinivalue_line("filterwarnings", r"ignore:.*(use solver\.|there is no error estimate):UserWarning")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that take long come first: see `LONGEST`."""

    def place(item: pytest.Item) -> int:
        return next((n for n, start in enumerate(LONGEST) if item.nodeid.startswith(f"tests/{start}")), len(LONGEST))

    items.sort(key=place)  # which keeps the order within a file


def pytest_collection_finish() -> None:
    """What was imported stays: nothing looks through it for garbage again (NiceGUI's tests collect all, twice each)."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000, 20, 20)  # tracing makes many objects, and little garbage
    gc.enable()
    global used
    used = sum(os.times()[:4])


# -- what the tests cost ----------------------------------------------------------------------------------------------

KEPT = pytest.StashKey[set[str]]()  # programs that were there before the tests
used = 0.0  # seconds of the processor at the last report


def _programs(cache: pytest.Cache) -> set[str]:
    """The programs that are kept; see `ertel.runs.exported`."""
    return {path.name for path in cache.mkdir("jax").glob("ertel/*") if path.suffix != ".partial"}


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Note the memory, and the processor time since the report before, of this process and of its ended ones."""
    global used
    report = yield
    before, used = used, sum(os.times()[:4])
    noted = {"seconds": used - before, "bytes": psutil.Process().memory_info().rss}
    report.user_properties = [*report.user_properties, *noted.items()]
    return report


def pytest_terminal_summary(terminalreporter: "pytest.TerminalReporter") -> None:
    """With `--costs` what costs most, in seconds of the processor, and the most memory of a worker after a test."""
    if not terminalreporter.config.getoption("costs"):
        return
    tests: Counter[str] = Counter()
    files: Counter[str] = Counter()
    memory: Counter[str] = Counter()
    for report in (each for kind in terminalreporter.stats.values() for each in kind):
        if "seconds" in (noted := dict(getattr(report, "user_properties", ()))):
            tests[report.nodeid] += noted["seconds"]
            files[report.nodeid.partition("::")[0]] += noted["seconds"]
            worker = getattr(report, "worker_id", "one process")
            memory[worker] = max(memory[worker], noted["bytes"])
    most = ", ".join(f"{worker} {size / 1e9:.2f} GB" for worker, size in sorted(memory.items()))
    terminalreporter.section(f"{sum(tests.values()):.0f} s of the processor; {most}")
    for name, seconds in (*files.most_common(30), *tests.most_common(60)):
        terminalreporter.line(f"{seconds:8.2f}  {name}")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail where the quick tests compile too many programs; they are counted where none was kept before."""
    config = session.config
    if hasattr(config, "workerinput") or config.getoption("markexpr") != "not slow" or config.stash.get(KEPT, {""}):
        return
    if (programs := len(_programs(config.cache))) > MOST_PROGRAMS:
        print(f"\nthe quick tests compile {programs} programs; at most {MOST_PROGRAMS}: see CONTRIBUTING.md")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def _xla_knows(flags: str) -> bool:
    """Whether this version of XLA knows these flags; it ends a process that is started with others."""
    command = [sys.executable, "-c", "import jax; jax.devices()"]
    done = subprocess.run(command, env={**os.environ, "XLA_FLAGS": flags}, capture_output=True, check=False)
    return done.returncode == 0


@pytest.fixture(autouse=True, scope="session")
def _programs_are_kept() -> None:
    """Keep programs as commands do: what one worker has traced, none traces again."""
    from ertel.runs.compile import start_at_once  # not above: what it imports reads the environment

    start_at_once()


@pytest.fixture(autouse=True, scope="module")
def _panels_lie_where_they_may(request: pytest.FixtureRequest) -> Iterator[None]:
    """Where panels lie takes most of the time of a picture; only the tests of pictures look at it."""
    with pytest.MonkeyPatch.context() as patch:
        if request.path.parent.name != "plots":
            patch.setattr("matplotlib.layout_engine.ConstrainedLayoutEngine.execute", lambda engine, figure: None)
        yield


@pytest.fixture(autouse=True, scope="module")
def _memory_is_bounded() -> Iterator[None]:
    """Forget compiled programs where there are many; a worker would reach 6 GB."""
    yield
    if psutil.Process().memory_info().rss < MOST_MEMORY or "ertel.numerics.programs" not in sys.modules:
        return
    import jax

    from ertel.numerics.programs import Program  # not above: what it imports reads the environment

    jax.clear_caches()
    for module in [each for name, each in sys.modules.items() if name.startswith("ertel.")]:
        for program in [each for each in vars(module).values() if isinstance(each, Program)]:
            program._compiled.clear()
    gc.collect()
    with suppress(OSError, AttributeError):  # GNU's library keeps what is freed
        ctypes.CDLL("libc.so.6").malloc_trim(0)


@pytest.fixture(scope="session")
def lines(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two stored runs of line contacts: `steady`, in SI, and `impact`, to the rebound, without."""
    import ertel  # not above: what it imports reads the environment

    folder, oil = tmp_path_factory.mktemp("lines"), ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa")
    track = {"load": "2 kN", "mean_speed": "1 m/s", "slide_to_roll": 0.0001}
    rolling = ertel.rolling(radius="10 mm", length="10 mm", E_prime="226 GPa", oil=oil, nodes=129, **track)
    ertel.run(rolling, folder / "steady")
    ertel.run(ertel.impact(M=20, L=10, radius_ratio=0, nodes=129, until="rebound", interval=0.1), folder / "impact")
    return folder


@pytest.fixture
def nothing_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    """P = 0 at the edge of every grid, as in the reference computations: the oil outside resists nothing."""
    from ertel.equations import outside  # not above: what it imports reads the environment

    for name in ("far_pressure", "rigid_pressure"):
        monkeypatch.setattr(outside, name, lambda X, Y, *_: 0.0 * X * Y)
