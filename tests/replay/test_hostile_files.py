"""Whatever a file says: it is read in bounded memory and time, or refused in one line."""

from __future__ import annotations

import struct
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import pytest
import zstandard

from archo_tui.base.errors import ArchoError
from archo_tui.recordings.replay import mcap_file
from archo_tui.recordings.replay.bag import BagFile
from tests.replay.bags import (
    ALWAYS,
    channel,
    chunk,
    drive,
    log,
    logs,
    message,
    read,
    record,
    schema,
    text,
    words,
    written,
)
from tests.support.night import corners

MOST_MEMORY = 200_000_000  # bytes: a record of the largest size, packed and unpacked, and more
HUGE = (2**64 - 1, 2**63, 2**40, 2**32 - 1, 2**31, 2**26, 65535)
SENT = 40  # messages of a file before it is changed
BATCHES = 20

GOOD = message(1, 5, log("good"))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """The same recording, packed in each way."""
    ways: list[tuple[str, dict[str, Any]]] = [
        ("zstd", {}),
        ("lz4", {}),
        ("none", {"enable_crcs": False}),
        ("none", {"use_chunking": False}),
        ("none", {"chunk_size": 500, "use_statistics": False, "enable_crcs": False}),
        ("zstd", {"chunk_size": 500, "enable_crcs": False}),
        ("lz4", {"chunk_size": 500, "enable_crcs": False}),
    ]
    path = tmp_path_factory.mktemp("files") / "a.mcap"
    return [written(path, drive(SENT), how, **more).read_bytes() for how, more in ways]


def changed(random: Random, data: bytes) -> bytes:
    """With flipped bits, and pieces cut out, put in, doubled, or made huge numbers."""
    made = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 2, 4, 16))):
        place = random.randrange(8, len(made) + 9)
        piece = made[place : place + random.randrange(2000)]
        match random.randrange(7):
            case 0:
                made[place : place + 1] = bytes(n ^ 1 << random.randrange(8) for n in piece[:1])
            case 1:
                del made[place:]
            case 2:
                made[place:place] = random.randbytes(random.randrange(1, 40))
            case 3:
                made[place : place + 8] = random.choice(HUGE).to_bytes(8, "little")
            case 4:
                made[place : place + 4] = random.choice(HUGE[3:]).to_bytes(4, "little")
            case 5:
                made[place:place] = piece
            case _:
                del made[place : place + random.randrange(1, 40)]
    return bytes(made)


def open_changed(files: list[bytes], seed: int, path: Path) -> None:
    """One changed file: all that must hold of it."""
    random = Random(seed)
    path.write_bytes(changed(random, random.choice(files)))
    try:
        found = BagFile(path)
    except ArchoError:
        return
    some = read(found)
    assert len(some) <= 4 * SENT  # doubled pieces hold messages too
    assert all(one.topic in found.types for one in some)
    assert [one.time for one in some] == sorted(one.time for one in some)
    assert len(found.faults) < 20
    assert all(fault.isprintable() for fault in found.faults)


def peak(work: Callable[[], object]) -> int:
    """Bytes that Python held at once in addition."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("batch", corners([0, 1], range(2, BATCHES)))
def test_changed_files_are_read_or_refused_in_little_memory(
    batch: int, files: list[bytes], tmp_path: Path
) -> None:
    def work(*seeds: int) -> None:
        for seed in seeds:
            open_changed(files, seed, tmp_path / "a.mcap")

    work(*range(batch, 2000, BATCHES))
    # Tracing costs five times as much: a few are enough.
    assert peak(lambda: work(*range(2000 + batch, 2400, BATCHES))) < MOST_MEMORY


def zstd_bomb(size: int) -> bytes:
    made = zstandard.ZstdCompressor().compressobj()
    parts = [made.compress(bytes(10**6)) for _ in range(size // 10**6)]
    return b"".join(parts) + made.flush()


def lz4_bomb(size: int) -> bytes:
    made = lz4.frame.LZ4FrameCompressor()
    parts = [made.begin(), *(made.compress(bytes(10**6)) for _ in range(size // 10**6))]
    return b"".join([*parts, made.flush()])


# a frame that holds a message as it is, but asks for 2 GB to look back in
_BLOCK = struct.pack("<I", 1 | len(GOOD) << 3)[:3]
WINDOW = b"\x28\xb5\x2f\xfd\x00" + bytes([(31 - 10) << 3]) + _BLOCK + GOOD
BOMB = 300_000_000  # bytes, five times as many as are ever unpacked
CHUNKS: dict[str, Callable[[], bytes]] = {
    "zstd": lambda: chunk(zstd_bomb(BOMB), "zstd", size=1000),
    "zstd, huge": lambda: chunk(zstd_bomb(BOMB), "zstd", size=2**64 - 1),
    "zstd, window": lambda: chunk(WINDOW, "zstd", size=len(GOOD)),
    "lz4": lambda: chunk(lz4_bomb(BOMB), "lz4", size=1000),
    "unknown": lambda: chunk(b"x" * 100, "bz2\x1b[2J"),
    "no zstd": lambda: chunk(GOOD, "zstd"),
    "empty": lambda: record(6, b""),
    "one in another": lambda: chunk(GOOD[:-1]),
}


@pytest.mark.parametrize("which", CHUNKS)
def test_a_hostile_chunk_is_left_out_alone(which: str, tmp_path: Path) -> None:
    path = logs(tmp_path / "a.mcap", GOOD, CHUNKS[which](), GOOD)

    def work() -> None:
        found = BagFile(path)
        assert words(found) == ["good", "good"]
        (fault,) = found.faults
        assert "the chunk at " in fault
        assert fault.isprintable()

    assert peak(work) < MOST_MEMORY


@pytest.mark.posix
def test_bombs_are_opened_in_little_memory_of_the_process_too(tmp_path: Path) -> None:
    """Tracemalloc does not see what zstd and lz4 take for themselves."""
    pytest.importorskip("resource")
    bombs = [make() for make in CHUNKS.values()]
    path = logs(tmp_path / "a.mcap", GOOD, *bombs, GOOD)
    script = (
        "import resource, sys; from pathlib import Path\n"
        "from archo_tui.ros import engine; engine.ensure()\n"
        "from archo_tui.recordings.replay.bag import BagFile\n"
        "import zstandard, lz4.frame, mcap.records, rclpy.serialization\n"
        "held = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        f"resource.setrlimit(resource.RLIMIT_AS, [held + {MOST_MEMORY}] * 2)\n"
        "found = BagFile(Path(sys.argv[1]))\n"
        "print(len(list(found.messages(0, 1e12, ['/rosout']))))\n"
    )
    if sys.platform != "linux":
        pytest.skip("the size of a process is read from /proc")
    given = [sys.executable, "-c", script, str(path)]
    assert subprocess.run(given, capture_output=True, text=True, check=True).stdout == "2\n"


def huge_records() -> dict[str, list[bytes]]:
    """Records that lie about their length, behind a good message: the reading ends there."""
    made = {
        f"{opcode}, {length:#x}": [GOOD, record(opcode, bytes(40), length)]
        for opcode in (1, 3, 4, 5, 7, 8, 9, 12, 200)
        for length in (2**64 - 1, 2**40)
    }
    made["opcode 0"] = [GOOD, bytes(90)]
    return made


@pytest.mark.parametrize("which", huge_records())
def test_a_length_that_cannot_be_ends_the_reading(which: str, tmp_path: Path) -> None:
    path = logs(tmp_path / "a.mcap", *huge_records()[which], GOOD)

    def work() -> None:
        found = BagFile(path)
        assert words(found) == ["good"]
        (fault,) = found.faults
        assert "cut off or damaged after " in fault

    assert peak(work) < MOST_MEMORY


@pytest.mark.parametrize(
    "behind",
    [
        *(b"", record(6, bytes(50), 10**10 - 10**6), record(200, b"", 9), record(5, b"", 10**9)),
    ],
    ids=range(4),
)
def test_a_file_of_10_gb_of_nothing_is_read_at_once(behind: bytes, tmp_path: Path) -> None:
    path = logs(tmp_path / "a.mcap", GOOD)
    data = path.read_bytes()[:-13]
    with open(path, "wb") as file:
        file.write(data + behind)
        file.truncate(10**10)

    def work() -> None:
        found = BagFile(path)
        assert words(found) == ["good"]
        assert found.faults

    assert peak(work) < MOST_MEMORY
    path.unlink()


UNKNOWN = record(0x10, b"x" * 100) + record(0xFF, b"")
AGAIN = schema(1, "std_msgs/msg/String", "string data") + channel(1, 1, "/other")


@pytest.mark.parametrize(
    ("parts", "count", "fault"),
    [
        ([UNKNOWN, GOOD, chunk(UNKNOWN + GOOD + UNKNOWN), UNKNOWN], 2, ""),
        ([chunk(GOOD + record(5, b"abc")), GOOD], 2, " bytes: damaged"),
        ([GOOD, record(15, bytes(5)), record(2, bytes(3)), GOOD], 2, ""),  # no end
        ([AGAIN, GOOD], 1, ""),
        (
            [message(1, 4, log("x" * 4_000_000)), GOOD],
            1,
            "/rosout: some messages cannot be read: larger than 4 MB",
        ),
    ],
    ids=["unknown kinds", "without a head", "an end in the middle", "known again", "too large"],
)
def test_what_is_odd_is_skipped_and_what_is_lost_is_told(
    parts: list[bytes], count: int, fault: str, tmp_path: Path
) -> None:
    found = BagFile(logs(tmp_path / "a.mcap", *parts))
    assert words(found) == ["good"] * count
    assert [line[-len(fault) :] for line in found.faults] == ([fault] if fault else [])
    assert set(found.types) == {"/rosout"}


def many_channels() -> list[bytes]:
    return [channel(n, n % 3, f"/topic_{n}" + "x" * 400) for n in range(20_000)]


def large_definitions() -> list[bytes]:
    first = schema(201, "std_msgs/msg/String", "string data\n" * 30_000)
    large = [schema(n, "std_msgs/msg/String", "# comment\n" * 25_000) for n in range(2, 200)]
    used = [channel(n, n, f"/topic_{n}") for n in range(2, 200)]
    return [first, *large, *used, schema(200, "std_msgs/msg/String", "string data\n" * 1_000_000)]


@pytest.mark.parametrize(
    ("made", "least", "most", "said"),
    [(many_channels, 2000, 8000, "a channel is left out: "), (large_definitions, 1, 200, "")],
)
def test_as_many_channels_and_definitions_are_known_as_anybody_needs(
    made: Callable[[], list[bytes]], least: int, most: int, said: str, tmp_path: Path
) -> None:
    path = logs(tmp_path / "a.mcap", *made(), GOOD)

    def work() -> None:
        found = BagFile(path)
        assert least <= len(found.types) < most
        assert words(found) == ["good"]
        assert f"{said}all of them are larger than 16 MB" in " ".join(found.faults)
        assert len(found.faults) <= 101

    assert peak(work) < MOST_MEMORY


@pytest.mark.parametrize(
    "name",
    [
        *("antigravity/msg/X", "os.path/msg/join", "../x/msg/Y", "rcl_interfaces/msg/__name__", ""),
        *("rcl_interfaces/srv/GetParameters", "std_msgs/msg/" + "S" * 100_000, "\x1b[2J/msg/X"),
        "archo_interfaces/action/_FeedbackMessage",
    ],
    ids=lambda name: name[:30],
)
def test_a_name_in_a_file_imports_nothing_but_interfaces(name: str, tmp_path: Path) -> None:
    known = set(sys.modules)
    parts = schema(2, name, "string data") + channel(2, 2, "/other")
    found = BagFile(logs(tmp_path / "a.mcap", parts, message(2, 5, log("x")), GOOD))
    assert words(found) == ["good"]
    assert [one.topic for one in found.messages(*ALWAYS, {"/other"})] == []
    (fault,) = found.faults
    assert fault.isprintable()
    assert "is not installed here" in fault or len(name) > 500
    new = {module.partition(".")[0] for module in set(sys.modules) - known}
    assert new <= {"rcl_interfaces", "archo_interfaces", "std_msgs"}


def test_definitions_that_contain_themselves_have_an_end(tmp_path: Path) -> None:
    rule = "=" * 80
    parts = []
    for number, name in ((2, "Log"), (3, "Time")):
        given = f"{name} self\n{rule}\nMSG: rcl_interfaces/{name}\n{name}[] self\n" * 500
        known = schema(number, "rcl_interfaces/msg/Log", given)
        parts += [known, channel(number, number, f"/other_{number}")]
    found = BagFile(logs(tmp_path / "a.mcap", *parts, GOOD))
    assert words(found) == ["good"]
    assert len(found.faults) == 2


def test_a_pass_that_takes_too_long_ends_with_what_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packed = chunk(GOOD * 100)
    path = logs(tmp_path / "a.mcap", *[packed] * 20)
    monkeypatch.setattr(mcap_file, "_MAX_RECORDS", 1000)
    found = BagFile(path)
    assert 500 < len(words(found)) <= 1000
    assert found.faults == ["a.mcap: more than 1,000 records: the rest is left out"]
    monkeypatch.setattr(mcap_file, "_MAX_RECORDS", 10**6)
    monkeypatch.setattr(mcap_file, "_MAX_BYTES", 7 * len(packed))  # read, and unpacked
    found = BagFile(path)
    assert len(words(found)) == 300
    assert found.faults == ["a.mcap: more than 0 GB: the rest is left out"]


def test_attachments_without_end_are_not_read(tmp_path: Path) -> None:
    def attached(name: str, data: bytes, length: int) -> bytes:
        given = struct.pack("<QQ", 0, 0) + text(name) + text("text/plain")
        return record(9, given + struct.pack("<Q", length) + data + bytes(4))

    robots = [attached("robot.yaml", b"name: X\n", size) for size in (2**64 - 1, 2**40, 8, 3)]
    others = [attached("robot.yam", b"", 0), attached("video.mp4", bytes(2_000_000), 2_000_000)]
    found = BagFile(logs(tmp_path / "a.mcap", *others, *robots, GOOD))
    assert words(found) == ["good"]
    assert found.robot == "name: X\n"


def test_what_a_file_calls_its_parts_cannot_move_the_cursor(tmp_path: Path) -> None:
    evil = "/\x1b]0;owned\x07\x1b[2J\u202e"
    parts = [schema(2, evil, evil), channel(2, 2, evil), channel(3, 1, evil, evil)]
    bad = [message(1, 5, b"\x00\x01\x00\x00" + evil.encode() * 9), message(4, 5, b"")]
    parts.append(channel(4, 1, f"{evil}/log"))
    found = BagFile(logs(tmp_path / "a.mcap", *parts, *bad, chunk(b"x", evil), GOOD))
    assert [one.message.msg for one in read(found)] == ["good"]
    assert len(found.faults) == 5
    assert all(fault.isprintable() for fault in found.faults)
