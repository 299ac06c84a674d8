from pathlib import Path

import pytest

from tests.experiments.command import command


@pytest.mark.parametrize("job", ["compare", "run"])
@pytest.mark.parametrize("out", ["recorded", "link", "elsewhere/../recorded", "home"])
def test_a_replay_into_its_own_recording_is_refused_before_anything_is_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, job: str, out: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("recorded", "home", "elsewhere"):
        Path(folder).mkdir()
    for name in ("frames.parquet", "estimates.parquet"):
        Path("home", name).write_text("precious")
        Path("recorded", name).symlink_to(Path("..", "home", name))
    Path("link").symlink_to("recorded")
    told = command(capsys, job, "--estimator", "replay", "--recorded", "recorded", "--out", out)
    assert (told.code, told.out) == (2, "")
    assert f"--out {out} would replace the recording in recorded: expected another folder" in told.err
    assert {path.name for path in Path("home").iterdir()} == {"frames.parquet", "estimates.parquet"}
    assert {path.name for path in Path("recorded").iterdir()} == {"frames.parquet", "estimates.parquet"}
    assert {path.read_text() for path in Path("home").iterdir()} == {"precious"}
