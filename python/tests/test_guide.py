"""A table that is driven by a guide."""

import json
import time
from pathlib import Path

import pytest
import tumble
from cases import EXAMPLES

FOLDER = EXAMPLES / "28-guided-calibration"


def test_a_table_is_driven(tmp_path: Path) -> None:
    schedule = json.loads((FOLDER / "schedule.campaign.json").read_text())
    guide = tumble.guide(schedule, noise={"V": 1e-4}, goal=8, output=tmp_path / "own.campaign.json")
    taken: list[dict[str, float]] = []
    for step in guide:
        assert step.error is None and step.readings == len(taken)
        assert step.goals[0].goal == pytest.approx(8 / 3600 * 3.141592653589793 / 180)
        if step.next is None:
            assert step.ended == "reached" and "done: every goal is met" in step.say
            break
        assert f"next: position {step.next.position}" in str(step).replace("\n ", "")
        taken.append(dict(step.next.set))
        row = {"position": step.next.position, **step.next.set}
        # what the table reads there, of readings so far
        measured = tumble.simulate({**schedule, "readings": [{"position": str(k), **own} for k, own in enumerate(taken)]}, FOLDER / "hidden.truth.json")
        step.answer({**row, "V": measured["readings"][-1]["V"]})
    with pytest.raises(StopIteration):
        next(guide)
    assert guide.reached
    assert len(guide.campaign["readings"]) == len(taken)
    assert tumble.diagnose(guide.campaign).effects[0].regressor == "a_O^2"


def test_answers_that_are_refused_or_taken_back(tmp_path: Path) -> None:
    guide = tumble.guide(FOLDER / "schedule.campaign.json", noise={"V": 1e-4}, output=tmp_path / "own.campaign.json")
    step = next(guide)
    with pytest.raises(RuntimeError, match="was not answered"):
        next(guide)
    step.answer({"W": 1})
    with pytest.raises(RuntimeError, match="only the last one"):
        step.answer({"V": 1})
    step = next(guide)
    assert step.error is not None and "no 'W'" in step.error
    step.answer({"V": -116.88})
    step = next(guide)
    assert step.readings == 1
    step.undo()
    assert next(guide).readings == 0
    guide.close()
    assert guide.reached is False
    # and on from the journal
    again = tumble.guide(FOLDER / "schedule.campaign.json", noise={"V": 1e-4}, output=tmp_path / "own.campaign.json", resume=True)
    assert next(again).readings == 0
    again.close()


def test_a_truth_takes_the_place_of_the_table(tmp_path: Path) -> None:
    guide = tumble.guide(
        FOLDER / "schedule.campaign.json", noise={"V": 1e-4}, goal=8, simulate=FOLDER / "hidden.truth.json", output=tmp_path / "own.campaign.json"
    )
    steps = list(guide)
    assert steps[-1].ended == "reached" and guide.reached
    assert [step.readings for step in steps] == list(range(len(steps)))


def test_a_wrong_option_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(tumble.MalformedError, match="noise"):
        next(tumble.guide(FOLDER / "schedule.campaign.json", output=tmp_path / "own.campaign.json"))


def test_an_abandoned_guide_ends(tmp_path: Path) -> None:
    def begin(name: str) -> tumble.Guide:
        return tumble.guide(
            FOLDER / "schedule.campaign.json", noise={"V": 1e-4}, goal=1e-3, simulate=FOLDER / "hidden.truth.json", most=300,
            output=tmp_path / f"{name}.campaign.json",
        )

    for step in begin("broken"):
        if step.readings == 2:
            break
    deleted, closed = begin("deleted"), begin("closed")
    next(deleted), next(closed)
    closed.close()
    assert closed.reached is None
    del deleted
    with pytest.raises(RuntimeError, match="guide is over"):
        step.undo()

    def taken() -> list[int]:
        return [len((tmp_path / f"{name}.journal.jsonl").read_text().splitlines()) for name in ("broken", "deleted", "closed")]

    # 300 readings take many seconds
    time.sleep(1)
    before = taken()
    time.sleep(1)
    assert taken() == before and max(before) < 200
