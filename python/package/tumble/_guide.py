"""A calibration that tells a table what to do next."""

from __future__ import annotations

import json
import weakref
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Optional, Union

from . import _tumble, reports
from ._commands import _flags, _further
from ._question import Files, Question, dumps
from ._tables import Path_


class Step(reports.GuideReport):
    """What is said after a reading: `next.set` has the joints to set (none at the end), `goals`, `diagnosis`, `mistake` and the rest are as in the
    JSON of the program, `error` says why the last answer was refused."""

    def __init__(self, guide: Guide, line: str) -> None:
        super().__init__(json.loads(line))
        # a guide that nobody else holds ends, as after `break`
        self._guide, self._line = weakref.ref(guide), line

    @property
    def say(self) -> str:
        """The same for a person."""
        return _tumble.guide_text(self._line)

    def __str__(self) -> str:
        return self.say

    def answer(self, reading: Mapping[str, Any]) -> None:
        """The reading of this position, `{"V": 0.0123}`; further keys, as in a campaign's readings, say that it was taken elsewhere."""
        self._reply(" ".join(dumps(dict(reading)).split("\n")))

    def undo(self, number: Optional[int] = None) -> None:
        """Take a reading back, the last one unless its number (from 1) is given, instead of an answer."""
        self._reply("undo" if number is None else f"undo {number}")

    def _reply(self, line: str) -> None:
        guide = self._guide()
        if guide is None:
            raise RuntimeError("the guide is over: nothing holds it any more")
        guide._reply(self, line)


class Guide(Iterator[Step]):
    """Steps of a calibration; see `guide`."""

    def __init__(self, files: Files, arguments: list[str], output: str, alone: bool) -> None:
        self._files = files
        self._conversation = _tumble.Conversation(arguments)
        self._output, self._alone = output, alone
        self._step: Optional[Step] = None

    def __next__(self) -> Step:
        if self._step is not None and self._step.ended is None and not self._alone:
            raise RuntimeError("the step was not answered: step.answer({...}), or step.undo()")
        try:
            line = self._conversation.next_line()
            self._step = None if line is None else Step(self, line)
        except KeyboardInterrupt:
            # a traceback may hold it for long
            self._conversation.stop()
            raise
        if self._step is None:
            raise StopIteration
        return self._step

    def _reply(self, step: Step, line: str) -> None:
        if step is not self._step or step.ended is not None:
            raise RuntimeError("the step is over: only the last one is answered, once")
        self._step = None
        self._conversation.say(line)

    def close(self) -> None:
        """End it before it ends: what was read is in the campaign (of a simulated one in the journal), and `resume=True` goes on. So does a guide that
        nothing holds any more, and one that Ctrl-C interrupts; what it had read is in the journal."""
        self._conversation.close()
        if self._alone:
            self._conversation.stop()
        self._step = None
        for _ in iter(self._conversation.next_line, None):
            pass

    @property
    def reached(self) -> Optional[bool]:
        """At the end: is every goal met, and nothing missing or all of it named?"""
        code = self._conversation.exit_code
        return None if code is None else code == 0

    @property
    def campaign(self) -> dict[str, Any]:
        """At the end: the ordinary campaign of the readings that stand."""
        content: dict[str, Any] = json.loads(Path(self._output).read_text(encoding="utf-8"))
        return content


def guide(
    schedule: Question,
    *,
    goal: Optional[Union[float, Mapping[str, float]]] = None,
    noise: Optional[Mapping[str, float]] = None,
    tilts: Optional[float] = None,
    cost: Optional[Mapping[str, float]] = None,
    step: Optional[float] = None,
    effects: Optional[Question] = None,
    most: Optional[int] = None,
    simulate: Optional[Question] = None,
    seed: Optional[int] = None,
    output: Path_ = "guided.campaign.json",
    resume: bool = False,
    **options: Any,
) -> Guide:
    """A calibration that tells the table what to do next: an iterator of steps, each of which is answered by a reading.

        for step in tumble.guide("schedule.campaign.json", noise={"V": 9e-4}, goal=1):
            print(step.say)
            if step.next is not None:
                step.answer({"V": my_table.read(**step.next.set)})

    goal: the standard uncertainty that is wanted (arcsec), of all angles or by name. noise: sd of one sample of each sensor, in its unit. tilts: their
    expected size, arcsec. cost: of `mounting`, `rate`, `reading`, `soak`, `degree`. step: of a sweep of candidates, deg. most: readings. simulate: a truth
    that takes the place of the table; its steps are not answered. Every reading is in a journal beside `output` before the next step is there; after a
    crash `resume` goes on from it. Further options as in `tumble guide --help`.
    """
    files = Files()
    given = {
        "goal": goal, "noise": noise, "tilts": tilts, "cost": cost, "step": step, "most": most, "seed": seed, "output": output, "resume": resume,
        "effects": None if effects is None else files.question(effects, "effects"),
        "simulate": None if simulate is None else files.question(simulate, "truth"),
    }
    command = ["guide", files.question(schedule, "campaign"), "--json=-"]
    return Guide(files, command + _flags({**given, **_further("guide", options)}), str(output), simulate is not None)
