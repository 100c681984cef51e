"""XML and YAML launch files: what each starts and says. All were compared with launch 3.7."""

from __future__ import annotations

from html import escape

import pytest

from archo_tui.user_code.ros_launch.evaluate import LaunchFileError
from archo_tui.user_code.ros_launch.plan import LaunchPlan
from tests.launch.planning import Launcher

XML = """<launch>
  <arg name="robot" default="r1" description="its name"/>
  <arg name="sim" default="false"/>
  <let name="hz" value="7.5"/>
  <set_env name="MODEL" value="$(var robot)_x"/>
  <node pkg="my_robot" exec="talker" name="$(var robot)_talker" output="screen"
        args="--quiet --count 3 $(var hz)" respawn="true" respawn_delay="2.0">
    <param name="rate" value="$(var hz)"/>
    <param name="pid"><param name="p" value="1.0"/></param>
    <param name="names" value="[a, b]" type="list_of_str"/>
    <param from="$(find-pkg-share my_robot)/config/params.yaml"/>
    <remap from="chatter" to="/$(var robot)/chatter"/>
    <env name="LEVEL" value="1"/>
  </node>
  <group if="$(var sim)"><node pkg="my_robot" exec="listener"/></group>
  <group unless="$(var sim)">
    <push-ros-namespace namespace="sub"/>
    <node pkg="my_robot" exec="listener"/>
  </group>
  <include file="$(find-pkg-share my_robot)/launch/talker.launch.py">
    <arg name="rate" value="$(eval '2 * $(var hz)')"/>
  </include>
  <timer period="2"><node pkg="my_robot" exec="talker"/></timer>
  <log message="in $(dirname)"/>
  <executable cmd="ls -l"/>
</launch>"""
YAML = """launch:
- arg: {name: robot, default: r1, description: its name}
- arg: {name: sim, default: "false"}
- let: {name: hz, value: "7.5"}
- set_env: {name: MODEL, value: $(var robot)_x}
- node:
    pkg: my_robot
    exec: talker
    name: $(var robot)_talker
    output: screen
    args: --quiet --count 3 $(var hz)
    respawn: "true"
    respawn_delay: 2.0
    param:
    - {name: rate, value: $(var hz)}
    - name: pid
      param: [{name: p, value: 1.0}]
    - {name: names, value: [a, b]}
    - {from: $(find-pkg-share my_robot)/config/params.yaml}
    remap: [{from: chatter, to: /$(var robot)/chatter}]
    env: [{name: LEVEL, value: "1"}]
- group:
    if: $(var sim)
    children: [{node: {pkg: my_robot, exec: listener}}]
- group:
    unless: $(var sim)
    children:
    - push_ros_namespace: {namespace: sub}
    - node: {pkg: my_robot, exec: listener}
- include:
    file: $(find-pkg-share my_robot)/launch/talker.launch.py
    arg: [{name: rate, value: $(eval '2 * $(var hz)')}]
- timer: {period: 2.0, children: [{node: {pkg: my_robot, exec: talker}}]}
- log: {message: in $(dirname)}
- executable: {cmd: ls -l}
"""


def plan_of(launcher: Launcher, text: str, *arguments: str) -> LaunchPlan:
    ending = "xml" if text.startswith("<") else "yaml"
    return launcher.plan(launcher.write(text, f"test.launch.{ending}"), *arguments)


def error_of(launcher: Launcher, text: str) -> str:
    with pytest.raises(LaunchFileError) as raised:
        plan_of(launcher, text)
    return str(raised.value).removeprefix(f"{launcher.folder}/test.launch.")


@pytest.mark.parametrize(("text", "line"), [(XML, 6), (YAML, 6)])
def test_xml_and_yaml_start_what_python_starts(launcher: Launcher, text: str, line: int) -> None:
    plan = plan_of(launcher, text)
    assert launcher.commands(plan) == [
        "my_robot talker --quiet --count 3 7.5 --ros-args -r __node:=r1_talker -p rate:=7.5 "
        "-p pid.p:=1.0 -p names:=[a, b] --params-file PREFIX/share/my_robot/config/params.yaml "
        "-r chatter:=/r1/chatter",
        "my_robot listener --ros-args -r __ns:=/sub",
        "my_robot talker --ros-args -p rate:=15.0",
        "my_robot talker",
    ]
    first, *_, last = plan.programs
    assert (first.line, first.respawn, first.respawn_delay) == (line, True, 2.0)
    assert first.environment == {"MODEL": "r1_x", "LEVEL": "1"}
    assert last.start_delay == 2.0
    said, left_out = plan.notes
    assert said.text.endswith("/share/my_robot/launch")  # Of the file that was included last.
    assert left_out.text.startswith("executable does not run here")
    assert [(one.name, one.default, one.description) for one in plan.arguments[:2]] == [
        ("robot", "r1", "its name"),
        ("sim", "false", ""),
    ]


def test_python_includes_xml_and_yaml(launcher: Launcher) -> None:
    include = '<launch><arg name="n"/><node pkg="my_robot" exec="talker" name="$(var n)"/></launch>'
    launcher.write(include, "inner.launch.xml")
    launcher.write("launch: [{node: {pkg: my_robot, exec: listener}}]", "inner.launch.yaml")
    folder = launcher.folder.as_posix()
    plan = launcher.of_actions(
        f"""
        IncludeLaunchDescription(AnyLaunchDescriptionSource('{folder}/inner.launch.xml'),
                                 launch_arguments=[('n', 'a')]),
        IncludeLaunchDescription('{folder}/inner.launch.yaml'),
        """
    )
    assert launcher.commands(plan) == [
        "my_robot talker --ros-args -r __node:=a",
        "my_robot listener",
    ]
    assert {"inner.launch.xml", "inner.launch.yaml"} <= {path.split("/")[-1] for path in plan.files}
    with pytest.raises(LaunchFileError, match=r"inner\.launch\.xml:1: SyntaxError"):
        launcher.of_actions(
            f"IncludeLaunchDescription(PythonLaunchDescriptionSource('{folder}/inner.launch.xml')),"
        )


TEXTS = {
    "plain $ text": "plain $ text",
    r"a\$(b": "a$(b",
    r"\\$(var x)": r"\$(var x)",
    "$$(var x)": "$v",
    "pre$(var x)post": "prevpost",
    "$(var $(var p))": "v",
    "$(var y z)": "z",
    "$(env NOPE 'a b')": "a b",
    "$(env NOPE '')": "",
    '$(env NOPE "x y")': "x y",
    r"$(env NOPE 'it\'s')": "it's",
    "$(env NOPE 'a(b)')": "a(b)",
    r"$(env NOPE a\(b\))": "a(b)",
    "$(env NOPE $(var x)/$(var p))": "v/x",
    "$(eval '1 + 1')": "2",
    "$(eval \"'$(var x)' == 'v'\")": "True",
    "$(eval 'os.sep' 'math, os')": "/",
    "$(not true)": "false",
    "$(and true 1)": "true",
    "$(equals 1 1.0)": "true",
    "$(not-equals a b)": "true",
    "$(if 0 a b)": "b",
    "": "",
}
WRONG_TEXTS = {
    "$(var  x)": "one blank is wanted between its words",
    "$(dirname )": "one blank is wanted between its words",
    "$(var x": "a blank or ) is wanted before '', or quotes",
    "$(vra x)": "there is no such substitution (nearest: var)",
    "$()": "there is no such substitution",
    "$(var)": "it is written $(var VARIABLE_NAME DEFAULT)",
    "$(eval 1 + 1)": "it is written $(eval EXPRESSION PYTHON_MODULES)",
    "$(env NOPE a(b))": "a blank or ) is wanted before '(b))', or quotes",
    "$(env NOPE 'a'b)": "a blank or ) is wanted before 'b)', or quotes",
    "$(env NOPE 'ab)": "its ' is not closed",
}


def logging(text: str) -> str:
    begin = '<launch><arg name="x" default="v"/><arg name="p" default="x"/>'
    return f'{begin}<log message="{escape(text)}"/></launch>'


def test_a_substitution_in_a_text_is_what_it_is_in_launch(launcher: Launcher) -> None:
    for text, said in TEXTS.items():
        assert [note.text for note in plan_of(launcher, logging(text)).notes] == [said], text


def test_a_file_is_read_into_a_text(launcher: Launcher) -> None:
    launcher.write("<robot/>", "robot.urdf")
    text = logging("$(file-content '$(dirname)/robot.urdf')")
    assert [note.text for note in plan_of(launcher, text).notes] == ["<robot/>"]
    assert error_of(launcher, logging("$(file-content no.urdf)")).endswith(
        "No such file or directory"
    )


def test_a_wrong_substitution_is_quoted_with_what_is_wanted(launcher: Launcher) -> None:
    for text, why in WRONG_TEXTS.items():
        assert error_of(launcher, logging(text)) == f"xml:1: {text}: {why}"


VALUES = {
    'value="1"': "1",
    'value="1e3"': "1e3",
    'value="yes"': "true",
    'value="[1, 2]"': "[1, 2]",
    "value=\"['$(env NOPE a)', b]\"": "[a, b]",
    'value="1" type="str"': "'1'",
    'value="1" type="float"': "1.0",
    'value="1" type="bool"': "true",
    'value="$(eval 2)"': "2",
    'value="$(eval 2)" type="str"': "'2'",
}
WRONG = {
    '<launch><node pkg="my_robot"/></launch>': "xml:1: node has no exec",
    '<launch>\n<node pk="my_robot" exec="talker"/></launch>': (
        "xml:2: node takes no pk (nearest: pkg)"
    ),
    '<launch><node pkg="my_robot" exec="talker" if="1" unless="1"/></launch>': (
        "xml:1: node has if and unless: give one"
    ),
    '<launch>\n\n<nod pkg="my_robot"/></launch>': ("xml:3: there is no action nod (nearest: node)"),
    "<launch": "xml:1: not XML: unclosed token",
    "<robot/>": "xml:1: it begins with robot, not launch",
    '<!DOCTYPE l [<!ENTITY a "b">]><launch><log message="&a;"/></launch>': (
        "xml:1: entities (&a;) are not read: write it out"
    ),
    "launch:\n- node: {pkg: my_robot, exec: talker, respawn: true}": (
        'yaml:2: respawn of node: a text is wanted: "true"'
    ),
    "launch:\n- node: {pkg: my_robot, exec: talker, param: {name: a, value: 1}}": (
        "yaml:2: param of node: a list is wanted, as `param: [{...}]`"
    ),
    "launch:\n- log: {message: a}\n  arg: {name: x}": (
        "yaml:2: each entry is one action, as `- node:`"
    ),
    "a: [": "yaml:1: not YAML: expected the node content, but found '<stream end>'",
    "robots: []": "yaml:1: it begins with robots, not launch",
}


def test_the_value_of_a_parameter_has_the_type_that_it_has_in_launch(launcher: Launcher) -> None:
    for attributes, value in VALUES.items():
        node = f'<node pkg="my_robot" exec="talker"><param name="a" {attributes}/></node>'
        found = launcher.commands(plan_of(launcher, f"<launch>{node}</launch>"))
        assert found == [f"my_robot talker --ros-args -p a:={value}"], attributes


def test_a_mistake_is_one_line_with_its_place(launcher: Launcher) -> None:
    for text, said in WRONG.items():
        assert error_of(launcher, text) == said


def test_a_file_that_is_too_large_says_so(launcher: Launcher) -> None:
    for name in ("test.launch.yaml", "test.launch.xml"):
        path = launcher.write(f"<!--{'x' * 1_100_000}--><launch/>", name)
        with pytest.raises(LaunchFileError, match="larger than"):
            launcher.plan(path)


def test_the_words_of_a_command_line_are_split_as_a_shell_does(launcher: Launcher) -> None:
    for args, words in {
        "a b  'c d'": ["a", "b", "c d"],
        "a$(var x)b c": ["avb", "c"],
        "$(var x) $(var x)": ["v", "v"],
        " $(var x)$(var x)": ["vv"],
    }.items():
        node = f'<node pkg="my_robot" exec="talker" args="{args}"/>'
        text = f'<launch><arg name="x" default="v"/>{node}</launch>'
        assert list(plan_of(launcher, text).programs[0].arguments) == words


@pytest.mark.parametrize("ending", ["xml", "yaml"])
def test_files_that_include_each_other_without_end_are_told(
    launcher: Launcher, ending: str
) -> None:
    def including(name: str) -> str:
        file = f"$(dirname)/{name}.launch.{ending}"
        if ending == "yaml":
            return f"launch:\n- include: {{file: {file}}}\n"
        return f'<launch>\n<include file="{file}"/>\n</launch>'

    for name, other in (("one", "two"), ("two", "one")):
        path = launcher.write(including(other), f"{name}.launch.{ending}")
    with pytest.raises(LaunchFileError, match=":2: these launch files include each other without"):
        launcher.plan(path)


def test_a_file_may_include_itself_while_a_condition_holds(launcher: Launcher) -> None:
    path = launcher.write(
        """\
        <launch>
          <arg name="count" default="3"/>
          <node pkg="my_robot" exec="talker" name="talker_$(var count)"/>
          <include file="$(filename)" if="$(eval '$(var count) &gt; 1')">
            <arg name="count" value="$(eval '$(var count) - 1')"/>
          </include>
        </launch>
        """,
        "self.launch.xml",
    )
    names = [program.name for program in launcher.plan(path).programs]
    assert names == ["talker_3", "talker_2", "talker_1"]
