"""A log is checked before a fit: what is odd in it is refused, asked or remarked by name, and a good log passes."""

import numpy as np
import pytest

import workbench as wb
from workbench.identification.datasets import DataFinding

T = np.arange(400) * 0.01
UNITS = {"v": "V", "omega": "rad/s", "i": "A"}
MOTOR = wb.open_loop(wb.DCMotor())  # whose slowest mode at its numbers takes 0.1 s


def good(t=T, units=UNITS, **other):
    """A log of a motor's voltage, speed and current, with noise."""
    rng = np.random.default_rng(4)
    signals = {"v": np.repeat(rng.choice([-6.0, 6.0], 40), 10), "omega": np.sin(3 * T), "i": np.cos(5 * T)}
    signals |= {name: signals[name] + 0.01 * rng.standard_normal(T.size) for name in ("omega", "i")}
    return wb.Dataset.of(np.asarray(t), {name: values[: len(t)] for name, values in (signals | other).items()}, units)


def check(log, **options):
    given = {"inputs": ["v"], "outputs": ["omega", "i"], "rate": 100.0, "system": MOTOR, "parameters": ["J", "b", "K"]}
    return wb.check_data(log, **given | options)


def points(checked):
    return [(one.severity, one.name) for one in checked.findings]


def test_a_good_log_passes_without_a_word():
    for log in (good(), good(np.round(T + 1e-6 * np.sin(1e4 * T), 7))):  # a clock of a microsecond
        checked = check(log)
        assert checked.findings == ()
        assert checked.is_passed
        checked.require()
        assert (repr(checked), str(checked)) == ("<DataCheck: passed>", "Nothing was found.")
    assert wb.check_data(good(), system=MOTOR).is_passed  # which knows its inputs and outputs


def test_a_jittering_log_passes_with_a_remark():
    checked = check(good(T + np.random.default_rng(1).uniform(-2e-3, 2e-3, T.size)))
    assert points(checked) == [("remark", "jitter")]
    assert checked.is_passed


def quantised(values, step):
    return step * np.round(values / step)


def test_quantised_signals_that_rest_or_turn_slowly_are_no_saturated_ones():
    swing = quantised(np.sin(3 * T), 0.02)
    rest = quantised(np.where(T < 2, 0.0, np.sin(T - 2) ** 3), 1e-3)
    assert check(good(omega=swing, i=rest)).findings == ()
    pulses = np.where(np.arange(T.size) % 50 == 7, 1.0, 0.0) + 0.1 * np.sin(T)  # of one sample, but they are many
    assert check(good(omega=pulses, i=np.clip(3.2 * np.sin(9 * T), -3.14, 3.14) * np.cos(T))).findings == ()
    step = np.where(T < 1, 0.0, 1 - np.exp(-(T - 1) / 0.05))  # at rest, at once in motion, and at rest for good
    assert check(good(omega=step, i=quantised(step, 1e-3))).findings == ()


ODD = {
    "time backward": (
        good(np.where(T > 2, T - 0.5, T)),
        "refused",
        "runs backward in 1 of its steps, first from 2 to 1.51 s",
    ),
    "time repeated": (good(np.where(T[7] == T, T[6], T)), "refused", "`log.merge_repeated('first')`"),
    "time missing": (good(np.where(T[7] == T, np.nan, T)), "refused", "row 7 has nan"),
    "time unit": (good(1000 * T), "refused", "median period is 10 s: the unit of its times seems to be ms"),
    "gap": (
        good(np.where(T > 2, T + 0.3, T)),
        "question",
        "about 30 missing samples in all; the first gap is from 2 to",
    ),
    "gap ": (
        good(np.cumsum(np.random.default_rng(3).choice([0.01, 0.02], T.size, p=[0.85, 0.15]))),
        "question",
        "steps are longer than 0.0185 s, with about",
    ),
    "missing samples: omega": (good(omega=np.where(T == 1, np.nan, np.sin(T))), "question", "first at 1 s"),
    "missing samples: v": (good(v=np.where(T == 1, np.nan, np.sign(np.sin(9 * T)))), "refused", "`log.resample`"),
    "constant signal: v": (good(v=np.full(T.size, 6.0)), "question", "constant at 6 in all 400 samples"),
    "constant signal: i": (good(i=np.zeros(T.size)), "refused", "look at the sensor"),
    "saturated signal: omega": (
        good(omega=np.minimum(np.sin(3 * T), 0.75)),
        "question",
        "mark_limits('omega', high=0.75)",
    ),
    "saturated signal: i": (good(i=np.maximum(quantised(np.sin(9 * T), 0.01), -0.5)), "question", "low=-0.5)"),
    "saturated signal: i ": (good(i=np.minimum(T, 3.0)), "question", "largest value 3 as if it were clipped"),
    "stuck signal: i": (
        good(i=np.where((T > 1) & (T < 1.5), 0.25, np.cos(5 * T))),
        "question",
        "from 1.01 s on are stuck",
    ),
    "outliers: omega": (
        good(omega=np.where((T == 1) | (T == 2.5), 9.0, np.sin(3 * T))),
        "question",
        "2 samples are farther from both neighbours than all others of 'log' go, first 9 at 1 s",
    ),
    "wrapped angle: i": (
        good(i=np.mod(9 * T, 2 * np.pi), units=UNITS | {"i": "rad"}),
        "question",
        "jumps by a full turn 5 times in 'log', first behind 0.69 s: add the turns by `log.unwrap(['i'])`",
    ),
    "unit missing: omega": (good(units={"v": "V", "i": "A"}), "question", "The system has it in [rad/s]"),
    "unit of another kind: i": (good(units=UNITS | {"i": "kg"}), "refused", "has it in [kg], a unit of another kind"),
    "unit scaled: i": (good(units=UNITS | {"i": "mA"}), "refused", 'write `log.convert({"i": "A"})`'),
    "too short": (good(T[:8]), "refused", "too short with 8 samples"),
}


@pytest.mark.parametrize("name", ODD)
def test_each_odd_log_is_named_in_one_sentence(name):
    log, severity, words = ODD[name]
    checked = check(log)
    assert (severity, name.strip()) in points(checked)
    finding = next(one for one in checked.findings if one.name == name.strip())
    assert words in finding.text
    assert "\n" not in finding.text
    assert not checked.is_passed
    with pytest.raises(ValueError, match="did not pass their check") as refusal:
        checked.require()
    assert finding.text in str(refusal.value)


def test_an_empty_log_is_too_short():
    checked = check(good(T[:0]))
    assert points(checked)[0] == ("refused", "too short")
    assert "the log is empty" in checked.findings[0].text


def test_a_signal_that_is_not_there_is_named_with_the_nearest():
    checked = check(good(), outputs=["omga"])
    assert points(checked)[0] == ("refused", "signal missing: omga")
    assert "Did you mean 'omega'?" in checked.findings[0].text
    other = wb.Dataset.of(T, {"v": np.sign(np.sin(T)), "speed": np.sin(T)}, {"v": "V", "speed": "rad/s"})
    assert ("refused", "signal unknown: speed") in points(check(other, outputs=["speed"]))


def test_a_constant_input_beside_another_is_a_remark():
    log = good().join(wb.Dataset.of(T, {"load": np.zeros(T.size)}, {"load": "N m"}))
    checked = wb.check_data(log, inputs=["v", "load"], outputs=["omega"])
    assert points(checked) == [("remark", "constant signal: load")]


def test_marked_samples_are_not_asked_about_again():
    log = good(omega=np.minimum(np.sin(3 * T), 0.75))
    assert check(log.mark_limits("omega", high=0.75)).is_passed


def test_a_question_is_answered_and_the_answer_is_kept():
    log = good(omega=np.minimum(np.sin(3 * T), 0.75), i=np.minimum(np.cos(5 * T), 0.5))
    checked = check(log)
    assert points(checked) == [("question", "saturated signal: omega"), ("question", "saturated signal: i")]
    one = checked.answer({"saturated signal: i": "the sensor ends at 0.5 A"})
    assert points(one) == [("question", "saturated signal: omega")]
    assert not one.is_passed
    both = checked.answer({"saturated signal": "both sensors end there"})
    assert both.is_passed
    assert both.answers == {"saturated signal": "both sensors end there"}
    assert [finding.signal for finding in both.answered_findings] == ["omega", "i"]
    assert repr(both) == "<DataCheck: passed, 2 answered>"
    assert "both sensors end there" in both._repr_html_()
    with pytest.raises(
        LookupError, match=r"no point 'gap' to answer\. The open questions are: 'saturated signal: omega'"
    ):
        checked.answer({"gap": "the recorder stopped"})
    with pytest.raises(ValueError, match="refuses the data, which no answer changes"):
        check(good(1000 * T)).answer({"time unit": "it is fine"})
    with pytest.raises(ValueError, match="text that says something"):
        checked.answer({"saturated signal": " "})


def test_a_log_shorter_than_the_slowest_mode_is_asked_about():
    tank = wb.open_loop(wb.QuadrupleTank())
    names = (*tank.inputs, *tank.outputs.names)
    rng = np.random.default_rng(7)
    units = {name: (tank.outputs if name in tank.outputs else tank.parameters)[name].unit for name in names}
    for span, found in ((10.0, ["too short"]), (2000.0, []), (2e6, ["time unit"])):
        t = np.linspace(0, span, 200)
        log = wb.Dataset.of(t, {name: rng.standard_normal(200) for name in names}, units)
        checked = wb.check_data(log, system=tank)
        assert [one.point for one in checked.open_findings] == found
        for finding in checked.open_findings:
            assert "the slowest mode of" in finding.text


@pytest.mark.parametrize(
    ("signal", "rank"), [(np.full(T.size, 3.0), 1), (T, 2), (np.sin(9 * T), 2), (np.sin(T) + np.sin(7 * T), 4)]
)
def test_the_excitation_of_an_input_is_the_rank_of_its_hankel_matrix(signal, rank):
    names = ["J", "b", "K", "R", "L"]
    log = wb.Dataset.of(T, {"v": signal, "y": np.sin(T)}, {"v": "V", "y": "m"})
    remark = next(
        one for one in wb.check_data(log, inputs=["v"], parameters=names).findings if one.point == "excitation"
    )
    assert (remark.severity, f"the rank of the Hankel matrix is {rank};" in remark.text) == ("remark", True)


def test_a_loop_is_a_system_and_several_experiments_are_checked_each():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=1.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    bad = wb.Dataset(
        (*good().experiments, *wb.Dataset.of(T, dict.fromkeys(("v", "omega", "i"), T), UNITS, name="ramp").experiments)
    )
    assert wb.check_data(bad, system=loop, inputs=["v"], outputs=["omega"]).findings[0].signal == "v"
    short = wb.Dataset(
        (*good().experiments, *wb.Dataset.of(T[:5], dict.fromkeys(UNITS, T[:5]), UNITS, name="stub").experiments)
    )
    assert "'stub' must have at least 10 samples" in check(short).findings[0].text


def test_a_finding_prints_its_point_and_sentence():
    assert str(DataFinding("gap", "question", "There is one.", "y")) == "question, gap: y. There is one."
