"""Long work leaves the interpreter free; commands run side by side."""

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import tumble
from cases import EXAMPLES, TABLE_1

PLAN = EXAMPLES / "18-plan-five-positions/published.campaign.json"


def test_the_interpreter_is_free() -> None:
    with ThreadPoolExecutor(1) as pool:
        work = pool.submit(tumble.fit, TABLE_1, monte_carlo=300_000)
        turns = 0
        while not work.done():
            turns += 1
    assert work.result().report.monte_carlo is not None
    # with the lock held there would be none, or a few at the ends
    assert turns > 1000


def test_commands_side_by_side(tmp_path: Path) -> None:
    def ask(k: int) -> tuple[str, int]:
        planned = tumble.plan(PLAN, noise={"V": 9e-4 * (1 + k % 2)})
        out = tmp_path / f"{k}-{threading.get_ident()}.json"
        code, _, error = tumble.run("simulate", EXAMPLES / "07-hidden-effect/schedule.campaign.json", "--truth",
                                    EXAMPLES / "07-hidden-effect/hidden.truth.json", "--seed", k, "--output", out)
        assert code == 0, error
        with pytest.raises(tumble.MalformedError, match=f"nothing-{k}"):
            tumble.check(f"nothing-{k}.campaign.json")
        return str(planned), len(out.read_text())

    alone = [ask(0), ask(1)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(ask, range(8)))
    assert [text for text, _ in together] == [alone[k % 2][0] for k in range(8)]
