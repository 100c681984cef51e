"""`archo-tui completions`: each shell that is installed takes what is printed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from archo_tui.cli import main


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_takes_its_completions(
    shell: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["completions", shell]) == 0
    text = capsys.readouterr().out
    for word in ("status", "consoles", "--watch", "--namespace"):
        assert word.lstrip("-") in text
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    file = tmp_path / "completions"
    file.write_text(text)
    begin = "autoload -U compinit && compinit -u -D && " if shell == "zsh" else ""
    done = subprocess.run(
        [shell, "-c", f"{begin}source {file}"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


COMPLETED = """
source {file}
COMP_WORDS=(archo-tui {words})
COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
$(complete -p archo-tui | sed 's/.*-F \\([^ ]*\\).*/\\1/') archo-tui "${{COMP_WORDS[COMP_CWORD]}}"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize(
    ("words", "wanted"),
    [("sta", "status"), ("--wat", "--watch"), ("go --w", "--wait"), ("completions fi", "fish")],
)
def test_bash_completes_verbs_and_options(
    words: str, wanted: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["completions", "bash"])
    file = tmp_path / "completions"
    file.write_text(capsys.readouterr().out)
    done = subprocess.run(
        ["bash", "-c", COMPLETED.format(file=file, words=words)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert wanted in done.stdout.splitlines(), done
