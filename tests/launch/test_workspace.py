"""Packages are those that colcon finds, executables those that setup.py names."""

from __future__ import annotations

import shutil
import textwrap
from pathlib import Path

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.user_code.ros_launch import child_process
from archo_tui.user_code.ros_launch import workspace as rooms
from archo_tui.user_code.ros_launch.setup_script import run_setup
from archo_tui.user_code.ros_launch.workspace import EntryPoint, Package, Workspace, read_package
from tests.launch.planning import WORKSPACE, Launcher

pytestmark = pytest.mark.posix  # Links, and / in paths.

SRC = WORKSPACE / "src"
NODES = Path(__file__).parent.parent.parent / "nodes"


def test_packages_are_found_at_any_depth_and_ignored_folders_are_not(workspace: Workspace) -> None:
    assert {p.name: p.build_type for p in workspace.packages.values()} == {
        "my_cpp": "ament_cmake",
        "my_interfaces": "ament_cmake",
        "my_robot": "ament_python",
        "my_tools": "ament_python",
    }
    assert workspace.problems == []
    assert workspace.interface_packages == {"my_interfaces": SRC / "my_interfaces"}


def test_a_launch_file_finds_its_package_and_the_workspace_around_it() -> None:
    found = Workspace.around(SRC / "my_robot" / "launch" / "talker.launch.py")
    assert set(found.packages) == {"my_cpp", "my_interfaces", "my_robot", "my_tools"}


def test_without_src_a_launch_file_finds_the_packages_beside_its_own() -> None:
    found = Workspace.around(NODES / "launch" / "archo_comms.launch.py")
    assert {"archo_bringup", "archo_interfaces"} <= set(found.packages)


def test_a_launch_file_without_a_package_finds_archos_own_only(tmp_path: Path) -> None:
    found = Workspace.around(tmp_path / "a.launch.py")
    assert found.packages == {}
    assert found.entry_point("archo_bringup", "dashboard") == EntryPoint(
        "archo_bringup.dashboard", "main", str(NODES)
    )


def test_archos_own_launch_file_starts_its_nodes_with_their_parameters(tmp_path: Path) -> None:
    file = NODES / "launch" / "archo_comms.launch.py"
    launcher = Launcher(tmp_path, Workspace.around(file), tmp_path / "prefix")
    names = ["battery_monitor", "dashboard", "motor_controller", "fake_battery_drain"]
    for argument, started in (("use_sim:=false", names[:3]), ("use_sim:=true", names)):
        programs = launcher.plan(file, argument).programs
        assert [program.executable for program in programs] == started
        for program in programs:
            assert "config/motor_params.yaml" in " ".join(program.ros_args)


def test_the_nodes_that_an_installed_console_carries_can_be_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(rooms, "_CHECKOUT", tmp_path)
    assert Workspace(()).entry_point("archo_bringup", "dashboard") == EntryPoint(
        "archo_bringup.dashboard", "main", ""
    )


def test_the_executables_are_what_setup_computes(workspace: Workspace) -> None:
    assert workspace.packages["my_tools"].executables() == {
        name: EntryPoint(f"my_tools.{name}", "main", str(SRC / "stack" / "my_tools"))
        for name in ("recorder", "player")
    }


def test_the_scripts_of_an_ament_cmake_package_are_executables(workspace: Workspace) -> None:
    folder = (SRC / "my_cpp").resolve()
    found = workspace.packages["my_cpp"].executables()
    assert found == {
        "count.py": EntryPoint(str(folder / "scripts" / "count.py"), "", str(folder)),
        "relay": EntryPoint(str(folder / "scripts" / "relay.py"), "", str(folder)),
        "lost.py": EntryPoint(str(folder / "scripts" / "lost.py"), "", str(folder)),
    }
    assert workspace.entry_point("my_cpp", "relay") == found["relay"]
    with pytest.raises(ArchoError, match=r"lost\.py in CMakeLists\.txt of my_cpp: there is no"):
        workspace.entry_point("my_cpp", "lost.py")


def test_a_workspace_without_a_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ArchoError, match="no package: a workspace has src/"):
        Workspace.below(tmp_path)


def test_a_home_folder_is_no_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rooms, "_MAX_FOLDERS", 3)
    for name in "abcd":
        (tmp_path / name).mkdir()
    with pytest.raises(ArchoError, match="more than 3 folders: name the workspace"):
        Workspace.below(tmp_path)


def write_package(folder: Path, text: str) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(text, encoding="utf-8")
    return folder


def test_what_is_wrong_with_a_package_xml_is_one_line_and_others_are_found(tmp_path: Path) -> None:
    write_package(tmp_path / "a", "<package><name>one</name></package>")
    write_package(tmp_path / "b", "<package>\n<name>")
    write_package(tmp_path / "c", "<package/>")
    write_package(tmp_path / "d", "<package><name>one</name></package>")
    write_package(tmp_path / "build" / "e", "<package><name>built</name></package>")
    (tmp_path / "loop").symlink_to(tmp_path)
    found = Workspace.below(tmp_path)
    assert [(p.name, p.build_type) for p in found.packages.values()] == [("one", "catkin")]
    assert [problem.removeprefix(f"{tmp_path}/") for problem in found.problems] == [
        "b/package.xml:2: not XML: no element found: line 2, column 6",
        "c/package.xml:1: no <name>: it names the package, <name>my_package</name>",
        f"d: another package one: {tmp_path / 'a'} is taken",
    ]


@pytest.fixture
def package(tmp_path: Path) -> Package:
    """A copy of a package, whose setup.py the test may change."""
    return read_package(shutil.copytree(SRC / "my_robot", tmp_path / "my_robot"))


SETUPS = {
    "raise ValueError('no')": "setup.py:1: ValueError: no, in: raise ValueError('no')",
    "import sys\nsys.exit()": "setup.py:2: SystemExit: it ends Python, exit code None, in: "
    "sys.exit()",
    "x = 1": "setup.py:1: it does not call setup()",
    "from setuptools import setup\nsetup(entry_points={'console_scripts': ['talker']})": (
        "setup.py:1: setup() is called wrongly: 'talker': write 'name = package.module:function'"
    ),
    "from setuptools import setup\nsetup(entry_points='talker = a.b:main')": (
        "setup.py:1: setup() is called wrongly: 'str' object has no attribute 'get'"
    ),
    "import os\nos._exit(3)": "setup.py: it ended Python, exit code 3",
}


def test_what_is_wrong_with_a_setup_is_one_line(package: Package) -> None:
    for text, line in SETUPS.items():
        (package.folder / "setup.py").write_text(text, encoding="utf-8")
        with pytest.raises(ArchoError) as raised:
            run_setup(package.build_file)
        assert str(raised.value).removeprefix(f"{package.folder}/") == line
    (package.folder / "setup.py").unlink()
    with pytest.raises(ArchoError, match="an ament_python package needs it"):
        run_setup(package.build_file)


def test_a_setup_that_says_too_much_is_told(
    package: Package, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(child_process, "_MAX_ANSWER", 1_000)
    text = f"from setuptools import setup\nsetup(data_files=[('{'x' * 2_000}', [])])"
    (package.folder / "setup.py").write_text(text, encoding="utf-8")
    with pytest.raises(ArchoError, match=r"setup\.py: its answer is over 0\.001 MB"):
        run_setup(package.build_file)


def test_a_setup_may_use_what_setuptools_has(package: Package) -> None:
    text = """
        from setuptools import Command, find_namespace_packages, find_packages, setup
        from setuptools.command.install import install

        class Install(install):
            def run(self):
                raise RuntimeError

        print("to be ignored")
        setup(
            packages=["a"] + find_packages(exclude=["test"]) + find_namespace_packages("b"),
            cmdclass={"install": Install},
            package_dir={"": "src"},
            entry_points={
                "console_scripts": [
                    "talker = my_robot.talker:main",
                    "listener=my_robot.listener:Listener.run [extra]",
                ],
            },
        )
    """
    (package.folder / "setup.py").write_text(textwrap.dedent(text), encoding="utf-8")
    setup = run_setup(package.build_file)
    assert setup.console_scripts == {
        "talker": ["my_robot.talker", "main"],
        "listener": ["my_robot.listener", "Listener.run"],
    }
    assert setup.source == "src"


def test_a_share_folder_has_what_setup_installs(package: Package, tmp_path: Path) -> None:
    package.fill_share_folder(tmp_path / "prefix")
    share = tmp_path / "prefix" / "share" / package.name
    found = sorted(path.relative_to(share).as_posix() for path in share.rglob("*.*"))
    assert found == ["config/params.yaml", "launch/talker.launch.py", "package.xml"]
    (package.folder / "config" / "params.yaml").write_text("changed", encoding="utf-8")
    assert (share / "config" / "params.yaml").read_text(encoding="utf-8") == "changed"


def test_a_file_that_setup_names_and_is_not_there_is_told(package: Package, tmp_path: Path) -> None:
    (package.folder / "config" / "params.yaml").unlink()
    with pytest.raises(ArchoError, match=r"setup\.py: data_files: config/params\.yaml is no file"):
        package.fill_share_folder(tmp_path / "prefix")


def test_a_share_folder_has_what_cmake_installs(workspace: Workspace, tmp_path: Path) -> None:
    package = workspace.packages["my_cpp"]
    package.fill_share_folder(tmp_path)
    share = tmp_path / "share" / package.name
    found = sorted(path.relative_to(share).as_posix() for path in share.rglob("*.*"))
    assert found == ["doc/README.md", "launch/driver.launch.py", "package.xml"]


def test_quotes_in_cmake_do_not_count(tmp_path: Path) -> None:
    folder = write_package(tmp_path / "ck", "<package><name>ck</name></package>")
    (folder / "launch").mkdir()
    (folder / "launch" / "a.launch.py").touch()
    text = 'install(DIRECTORY "launch/" DESTINATION "share/${PROJECT_NAME}/launch")'
    (folder / "CMakeLists.txt").write_text(text, encoding="utf-8")
    read_package(folder).fill_share_folder(tmp_path / "prefix")
    assert (tmp_path / "prefix" / "share" / "ck" / "launch" / "a.launch.py").is_file()
