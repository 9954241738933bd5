# SPDX-License-Identifier: MIT
"""motorsim debug as its users meet it: sessions from a file or a pipe, and what they are told."""

import fcntl
import os
import pty
import re
import select
import subprocess
import sys
import tempfile
import termios
import time
import unittest
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
DONE, BAD_INPUT = 0, 2
ROUND_TRIP = 10000
CTRL_C = "\x03"
LAST = 36000000   # of a prolonged scenario


class SessionTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_debug(self, arguments, commands):
        return subprocess.run([MOTORSIM, "debug", *arguments], input="\n".join(commands) + "\n",
                              cwd=self.folder, text=True, capture_output=True, check=False)

    def session(self, commands, scenario="s1_robust", status=DONE):
        """The answers, one text a command."""
        done = self.run_debug([scenario], commands)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return re.split(r"^\(\w+ \d+\) .*\n", done.stdout, flags=re.MULTILINE)[1:]

    def refused(self, command):
        """The one line that a bad command gets; the session goes on behind it."""
        before, answer, after = self.session(["hash", command, "hash"], status=BAD_INPUT)
        self.assertEqual(before, after)
        self.assertEqual(answer.count("\n"), 1, answer)
        return answer.strip()


class FindsAFault(SessionTest):
    def three_ticks_before_the_fault(self, injection):
        """Stages and verdict there."""
        answers = self.session(["goto 0.5s", injection, "run until fault", "back 3", "stages",
                                "diff"])
        stopped = re.search(r"tick (\d+)  t = \S+ s  FAULT", answers[2])
        self.assertIsNotNone(stopped, answers[2])
        self.assertIn(f"tick {int(stopped[1]) - 3} ", answers[3])
        self.assertNotIn("FAULT", answers[3])
        return answers[4], answers[5].splitlines()[-1]

    def test_a_stuck_result_is_found_by_its_word(self):
        stages, verdict = self.three_ticks_before_the_fault("force drive.rotor.position.turns_q32 = 0.25")
        self.assertRegex(stages, r"drive\.rotor\.position\.turns_q32 +0\.25 turns el")
        departure = re.fullmatch(r"first departure: state, drive\.rotor\.position\.turns_q32: drive 0\.25, "
                                 r"reference (\S+) turns el, tolerance 0", verdict)
        self.assertIsNotNone(departure, verdict)
        self.assertGreater(abs(float(departure[1]) - 0.25), 1 / 360)

    def test_a_corrupted_parameter_is_found_in_the_model(self):
        _, verdict = self.three_ticks_before_the_fault(
            "set drive.motor.model.observer.volt_gain.raw = 20000")
        self.assertRegex(verdict, r"^first departure: model, observer\.volt_gain: "
                                  r"drive 20000, reference 63\d\d")

    def test_a_healthy_run_departs_nowhere(self):
        for scenario in ("s1_robust", "s5"):
            answers = self.session(["goto 0.5s", "diff", "back 3", "diff"], scenario)
            for answer in (answers[1], answers[3]):
                self.assertIn("no departure", answer)

    def test_a_function_has_a_row_in_the_ticks_that_call_it(self):
        answers = self.session(["diff", "goto 0.5s", "diff"])
        self.assertNotIn("nn_observer_predict", answers[0])
        self.assertIn("nn_observer_predict", answers[2])
        for answer in (answers[0], answers[2]):
            self.assertRegex(answer, r"what lies between the functions above\nhas no twin")


class Steps(SessionTest):
    def test_ten_thousand_ticks_back_and_forth_end_in_the_same_hash(self):
        answers = self.session(["goto 12000", "hash", f"back {ROUND_TRIP}", f"step {ROUND_TRIP}",
                                "hash", f"back {ROUND_TRIP}", "hash", "goto 0", "goto 2000", "hash"])
        self.assertEqual(answers[1], answers[4])
        self.assertEqual(answers[6], answers[9])
        self.assertNotEqual(answers[1], answers[6].replace("2000", "12000"))

    def test_goto_takes_a_tick_or_a_time(self):
        answers = self.session(["goto 0.2s", "print time_s", "goto 100", "goto -0.1s"])
        self.assertIn("t = 0.2000 s", answers[0])
        self.assertIn("0.2 s", answers[1])
        self.assertIn("tick 100 ", answers[2])
        self.assertIn("t = -0.1000 s", answers[3])

    def test_ends_are_told(self):
        answers = self.session(["step 1000000", "back 1000000", "run"])
        self.assertIn("end of the scenario", answers[0])
        self.assertIn("beginning of the run", answers[1])
        self.assertIn("stopped: end of the scenario", answers[2])


class Stops(SessionTest):
    def test_run_until_stops_where_the_condition_begins_to_hold(self):
        answers = self.session(["run until speed_rpm > 1000 && state == RUN", "print speed_rpm",
                                "back", "print speed_rpm > 1000"])
        self.assertIn("stopped: speed_rpm > 1000 && state == RUN", answers[0])
        self.assertAlmostEqual(float(answers[1].split()[1]), 1000, delta=1.5)
        self.assertEqual(answers[3].strip(), "0")

    def test_break_on_state_stops_at_each_change(self):
        answers = self.session(["break on state", "run", "run", "run", "run"])
        states = [re.search(r" s  (\w+)  ", answer)[1] for answer in answers[1:]]
        self.assertEqual(states, ["READY", "FLYING_START", "ALIGN", "HOLD"])

    def test_break_on_fault_and_on_an_expression(self):
        fault = "scenario.fault=[{time_s=0.3, what=\"overcurrent\", value=19}]"
        done = self.run_debug(["s1_robust", "--set", fault],
                              ["break on fault", "break on speed_rpm > 100", "break", "run",
                               "delete 2", "run"])
        self.assertIn("1: break on fault\n2: break on speed_rpm > 100", done.stdout)
        self.assertIn("stopped: break on speed_rpm > 100", done.stdout)
        self.assertRegex(done.stdout, r"stopped: break on fault\n.*FAULT.*OVERCURRENT")

    def test_watched_signals_are_printed_at_each_stop(self):
        answers = self.session(["watch i_q_a drive.rotor.observer.speed", "step", "unwatch i_q_a", "step",
                                "unwatch", "step"])
        self.assertIn("i_q_a", answers[1])
        self.assertNotIn("i_q_a", answers[3])
        self.assertIn("drive.rotor.observer.speed", answers[3])
        self.assertNotIn("drive.rotor.observer", answers[5])


class Prints(SessionTest):
    def test_a_word_of_the_drive_has_si_value_raw_value_and_format(self):
        answer = self.session(["goto 0.5s", "print i_q_reference_a"])[1]
        value, raw, base = re.search(
            r"(\S+) A +raw (\S+) +Q15 of I_b = (\S+) A", answer).groups()
        self.assertAlmostEqual(float(value), int(raw) / 2**15 * float(base), places=5)

    def test_stages_are_in_the_order_of_the_tick(self):
        answer = self.session(["goto 0.5s", "stages"])[1]
        order = ["in.adc_ia", "i_a_measured_a", "i_alpha_a", "i_d_measured_a",
                 "v_alpha_applied_v", "observer.state.d", "observer.error.d",
                 "observer.gradient", "weight_change_rpm", "observer.speed_out", "current_ref.q",
                 "voltage.q", "compare.phase[2]"]
        places = [answer.index(name) for name in order]
        self.assertEqual(places, sorted(places))

    def test_stages_are_those_of_the_state(self):
        own = {"FLYING_START": "drive.start.flying_start.phase ", "ALIGN": "drive.start.align.phase ",
               "RUN": "drive.motion.speed_loop.pi.integral_q26 "}
        imposed = "drive.vector.current_mean.d "
        for state in (*own, "IF_RAMP"):
            stopped, shown = self.session([f"run until state == {state}", "stages"])
            self.assertIn(f"  {state}", stopped)
            self.assertEqual([one for one in own.values() if f"  {one}" in shown], [own[state]] if state in own else [])
            self.assertEqual(f"  {imposed}" in shown, state in ("ALIGN", "IF_RAMP"))

    def test_stages_are_those_of_the_drive_that_runs(self):
        sensed = self.session(["goto 0.5s", "stages"], "s4")[1]
        self.assertIn(" RUN, voltage-driven  ", sensed)
        for part in ("in.angle ", "drive.voltage_drive.magnitude ", "lead_el_deg ",
                     "drive.voltage_drive.compensator.angle "):
            self.assertIn(part, sensed)
        self.assertNotIn("current loop", sensed)
        regulated = self.session(["goto 0.5s", "stages"])[1]
        self.assertNotIn("in.angle", regulated)
        self.assertNotIn("compensator", regulated)


class Sets(SessionTest):
    def test_commands_and_parameters_act_from_here_on(self):
        answers = self.session(["goto 0.5s", "set speed_command_rpm = 400", "step 500",
                                "print speed_command_rpm", "set cfg.speed_loop.ramp = 1", "step 20",
                                "print state", "set"])
        self.assertIn("400 rpm", answers[3])
        self.assertIn("RUN ", answers[6])
        self.assertRegex(answers[7], r"set speed_command_rpm = 400 at tick \d+\nset cfg")

    def test_a_forced_count_reaches_the_drive(self):
        for count, scenario, fault in (("in.adc_ia.raw = 4095", "s1_robust", "ADC_SATURATED"),
                                       ("in.angle.raw = 0", "s4", "FAULT")):
            self.assertIn(fault, self.session(["goto 0.5s", f"force {count}", "run until fault"], scenario)[2])


class Refuses(SessionTest):
    def test_an_unknown_signal_lists_near_names(self):
        self.assertRegex(self.refused("print speed_rmp"), r"no signal speed_rmp; near: speed_rpm\b")
        self.assertIn("near: drive.rotor.observer.speed_out", self.refused("watch drive.rotor.observer.sped_out"))

    def test_what_is_like_no_name_lists_the_least_unlike(self):
        for command in ("print xyzzyplugh", "print x", "set zzz = 1", "watch cfg.qqqqqq.wwwwww", "release flux"):
            self.assertRegex(self.refused(command), r"there is no signal \S+; near:( \S+){5}; `signals` lists all$")
        self.assertIn("flux_q30", self.refused("print flux"))
        for command in ("xyzzyplugh", "q", "help zzzzzz"):
            self.assertRegex(self.refused(command), r"there is no command \S+; near:( \S+){1,3}; `help` lists all$")
        self.assertRegex(self.refused("x" * 101), "there is no command x{60}…; `help` lists them$")

    def test_a_bad_line_says_what_where_and_what_is_allowed(self):
        for command, part in (
                ("stepp", "there is no command stepp; near: step; `help` lists all"),
                ("step 0", "from 1 to 1000000000, found '0'"),
                ("step x", "found 'x'"),
                ("back 99999999999999999999", "found '99999999999999999999'"),
                ("goto 20000", "a tick is a whole number from 0 to 15422, found '20000'"),
                ("goto 2s", "a time is from -0.5423s to 0.9999s, found '2s'"),
                ("goto nans", "found 'nans'"),
                ("goto", "found ''"),
                ("run 5", "run until EXPR; found '5'"),
                ("run until", "column 1 of '': a value is missing"),
                ("run until speed_rpm >", "column 12"),
                ("break fault", "found 'fault'"),
                ("break on", "found 'on'"),
                ("delete 1", "there are no breaks"),
                ("print", "NAME... or EXPR"),
                ("print 1 +", "a value is missing"),
                ("print speed_rpm.raw", "speed_rpm has no raw value"),
                ("unwatch i_q_a", "i_q_a is not watched"),
                ("diff now", "'now' is one word too many"),
                ("set speed_rpm = 5", "speed_rpm is a result"),
                ("set out.compare.phase[0] = 1", "is a result"),
                ("set state = RUN", "is a result"),
                ("set drive.rotor.observer.speed", "NAME = VALUE; found 'drive.rotor.observer.speed'"),
                ("set in.adc_ia.raw = 65536", "from 0 to 65535, found 65536"),
                ("set drive.rotor.observer.speed.raw = 0.5", "found 0.5"),
                ("set drive.rotor.observer.speed = 1e300", "drive.rotor.observer.speed is from -150000 to 149999.9999 rpm, found 1e+300"),
                ("set drive.rotor.observer.speed.raw = 1e10",
                 "drive.rotor.observer.speed.raw is a whole number from -2147483648 to 2147483647, found 10000000000"),
                ("set drive.rotor.position.turns_q32.raw = 9007199254740994",
                 "is a whole number from -9007199254740992 to 9007199254740992, found 9007199254740994"),
                ("set drive.rotor.position.turns_q32 = 3e6",
                 "drive.rotor.position.turns_q32 is from -2097152 to 2097152 turns el, found 3000000"),
                ("set drive.rotor.residual = 0/0", "drive.rotor.residual is from -"),
                ("set cfg.slow_ticks.raw = 5", "refused by the drive: slow_ticks"),
                ("set position_command_rad = 1", "commands nothing in a run in speed mode"),
                ("release i_q_a", "i_q_a is not set at tick 0"),
                ("signals nothing_like_it", "no signal has 'nothing_like_it'"),
                ("help me", "there is no command me")):
            with self.subTest(command):
                self.assertIn(part, self.refused(command))

    def test_odd_input_does_not_end_the_session(self):
        self.session(["", "   ", "# a remark", "hash # with a remark", "\t"])
        self.refused("\x01\x02")
        self.refused("print " + "(" * 100000)
        self.refused("x" * 100000)

    def test_a_script_that_is_not_there(self):
        done = self.run_debug(["s1", "--script", "none.txt"], [])
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertEqual(done.stderr.strip(),
                         "motorsim: none.txt: cannot read: No such file or directory")


class Terminal(SessionTest):
    ANSWER_S = 120
    UNDER_WAY_S = 0.1   # of processor time
    PROLONGED = "scenario.duration_s=3600"   # half a minute to run

    def setUp(self):
        super().setUp()
        self.screen, line = pty.openpty()
        self.addCleanup(os.close, self.screen)
        self.process = subprocess.Popen([MOTORSIM, "debug", "s1", "--set", self.PROLONGED], stdin=line, stdout=line,
                                        stderr=line, cwd=self.folder, start_new_session=True,
                                        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
                                        env={**os.environ, "TERM": "xterm"})
        os.close(line)
        self.addCleanup(self.process.wait)
        self.addCleanup(self.process.kill)
        self.shown_until(r"\(s1 0\)")
        self.wait_for_keys()

    def wait_for_keys(self):
        """Until the terminal gives each key as it is typed: it does so behind the prompt."""
        while termios.tcgetattr(self.screen)[3] & termios.ICANON:
            time.sleep(0.01)

    def used_s(self):
        """Processor time of the debugger."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def begin(self, command, shown):
        """A command that takes long, until it is well under way."""
        before = self.used_s()
        self.types(command, shown)
        while self.used_s() < before + self.UNDER_WAY_S:
            time.sleep(0.01)

    def shown_until(self, pattern):
        text = ""
        while not re.search(pattern, text, flags=re.DOTALL):
            ready, _, _ = select.select([self.screen], [], [], self.ANSWER_S)
            self.assertTrue(ready, f"no {pattern} in {text!r}")
            text += os.read(self.screen, 4096).decode(errors="replace")
        return text

    def types(self, keys, pattern):
        os.write(self.screen, keys.encode())
        return self.shown_until(pattern)

    def interrupted(self):
        """The whole tick at which Ctrl-C stops it."""
        stopped = self.types(CTRL_C, r"\(s1 \d+\) $")
        tick = int(re.search(r"stopped: interrupted\r?\ntick (\d+) ", stopped)[1])
        self.assertIn(f"(s1 {tick})", stopped)
        return tick

    def test_a_tab_completes_commands_and_signals(self):
        self.types("got\t7\n", r"tick 7 ")
        self.types("print i_q_ref\t\n", r"i_q_reference_a +\S+ A +raw")

    def test_the_arrow_brings_the_last_line_again(self):
        self.types("goto 42\n", r"tick 42 ")
        self.types("step 3\n", r"tick 45 ")
        self.types("\x1b[A\x1b[A\n", r"tick 42 ")

    def test_ctrl_c_stops_a_run_at_a_whole_tick(self):
        self.begin("run until speed_rpm > 1e9\n", "until speed_rpm")
        tick = self.interrupted()
        there = self.types("hash\n", r"drive \w{8}")
        self.types("goto 0\n", "tick 0 ")
        self.types(f"goto {tick}\n", f"tick {tick} ")
        again = self.types("hash\n", r"drive \w{8}")
        self.assertEqual(*[re.search(r"drive \w{8}", text)[0] for text in (there, again)])

    def test_ctrl_c_stops_the_way_to_a_tick_there_and_back(self):
        for command in (f"goto {LAST}\n", f"step {LAST}\n"):
            self.begin(command, command[:4])
            self.assertTrue(0 < self.interrupted() < LAST)
            self.types("goto 0\n", "tick 0 ")

    def test_ctrl_c_clears_the_line_at_the_prompt(self):
        self.types("step 5\n", r"tick 5 .*\(s1 5\)")
        self.types("nonsense", "nonsense")
        self.types(CTRL_C, r"\(s1 5\) $")
        answer = self.types("step\n", r"tick \d+ ")
        self.assertIn("tick 6 ", answer)
        self.assertNotIn("no command", answer)


class Teaches(SessionTest):
    def test_every_command_is_explained(self):
        overview = self.session(["help"])[0]
        names = re.findall(r"^  (\w+) ", overview, flags=re.MULTILINE)
        self.assertIn("diff", names)
        for name, answer in zip(names, self.session([f"help {name}" for name in names])):
            self.assertGreater(len(answer.splitlines()), 2, name)

    def test_a_script_is_the_same_session_as_a_pipe(self):
        commands = ["step 5", "hash", "quit", "never read"]
        (self.folder / "commands.txt").write_text("\n".join(commands), encoding="utf-8")
        piped = self.run_debug(["s1"], commands)
        self.assertNotIn("never read", piped.stdout)
        for script, typed in (("commands.txt", []), ("-", commands)):
            done = self.run_debug(["s1", "--script", script], typed)
            self.assertEqual((done.stdout, done.returncode), (piped.stdout, DONE))


unittest.main()
