# SPDX-License-Identifier: MIT
"""Running campaigns: results, going on with them, making one run again, refusals."""

import json
import pickle
import shlex
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from dask.distributed import LocalCluster

from campaign_support import MINE, MOTORSIM, RUNS, CampaignTest
from support import TOOLS
from whole_file import whole_file
from robustness import campaign, execute, simulator, worker

PATIENCE_S = 60
OPTION_SEPARATOR = "  # "


def metrics(**changed):
    return {"accepted": False, "locked": False, "state_final": "RUN",
            "gates_enabled_final": True} | changed


class Classes(unittest.TestCase):
    def test_each_end_of_a_run_has_its_class_and_what_has_none_is_uncontrolled(self):
        fault, open_gates, held = {"state_final": "FAULT"}, {"gates_enabled_final": False}, {"locked": True}
        for changed, outcome in (({"accepted": True}, "locked"), (held | {"accepted": True}, "locked"),
                                 (held, "held, off limits"),
                                 (fault | open_gates, "failed safe"), (held | fault | open_gates, "failed safe"),
                                 ({}, "uncontrolled"), (fault, "uncontrolled"), (open_gates, "uncontrolled"),
                                 (held | open_gates, "uncontrolled"), (held | fault, "uncontrolled"),
                                 ({"faults": ["OVERCURRENT@3"]}, "uncontrolled")):
            self.assertEqual(simulator.outcome(metrics(**changed)), outcome, changed)

    def test_of_real_runs(self):
        for setting, expected in (("plant.flux_scale=1", "locked"),
                                  ("plant.bus_ripple_pct=40", "failed safe"),
                                  ("plant.resistance_scale=1.05", "held, off limits"),
                                  ("plant.resistance_scale=1.15", "uncontrolled")):
            done = subprocess.run([MOTORSIM, "run", "s1", "--json", "-", "--set", setting],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(simulator.outcome(json.loads(done.stdout)), expected, setting)


class MineTest(CampaignTest):
    """With the file of MINE."""

    def setUp(self):
        super().setUp()
        self.mine = self.file()

    def tool(self, command, *words):
        """The tool in a process of its own, which rerun gives the simulator's status."""
        return subprocess.run([sys.executable, "-B", TOOLS / "campaign", command, self.mine, "--motorsim", MOTORSIM,
                               *map(str, words)], capture_output=True, text=True, check=False)

    def assert_each_once(self):
        self.assertEqual([row["run"] for row in self.rows()], list(range(RUNS)))


class Running(MineTest):
    def test_every_run_is_in_the_results_once_whoever_runs_it(self):
        self.run_mine("--jobs", 1)
        self.assert_each_once()
        self.assertEqual({row["outcome"] for row in self.rows()}, {"locked", "failed safe"})
        self.run_mine("--jobs", 3, out="a")
        self.assertEqual(self.rows("a"), self.rows())
        with LocalCluster(n_workers=1, threads_per_worker=2, processes=True,
                          dashboard_address=None) as cluster:
            self.run_mine("--scheduler", cluster.scheduler_address, out="b")
        self.assertEqual(self.rows("b"), self.rows())

    def test_workers_need_no_files_of_the_tools(self):
        words = [1, [str(MOTORSIM), "run", "s9"], [], worker.fingerprint(str(MOTORSIM), [])]
        packed = pickle.dumps((execute.Portable(worker.simulate), words))
        done = subprocess.run(
            [sys.executable, "-c", "import pickle, sys; function, words = "
             "pickle.load(sys.stdin.buffer); print(*function(*words))"],
            input=packed, capture_output=True, cwd=self.folder, check=False)
        self.assertRegex(done.stdout.decode(), '^1 2  motorsim: .*"s9": not found')

    def test_the_files_beside_the_results(self):
        _, out, _ = self.run_mine(draws=True)
        for name in ("runs.csv", "failures.txt", "map.png"):
            self.assertIn(str(self.folder / "out" / name), out.splitlines())
        lines = (self.folder / "out" / "runs.csv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(len(lines), 1 + RUNS)
        self.assertTrue(lines[0].startswith("run,outcome,plant.resistance_scale,"))
        row = self.rows()[2]
        self.assertTrue(lines[3].startswith(",".join(["2", row["outcome"],
                                                      *row["values"].values()])))

    def test_a_table_that_is_not_finished_leaves_the_one_before(self):
        table = self.folder / "runs.csv"
        table.write_text("of yesterday", encoding="utf-8")
        with self.assertRaises(ValueError), whole_file(table) as file:
            file.write("half of it")
            raise ValueError
        self.assertEqual(table.read_text(encoding="utf-8"), "of yesterday")
        self.assertEqual(list(self.folder.glob("*.part")), [])

    def test_a_signal_in_the_middle_of_a_file_leaves_the_one_before(self):
        table = self.folder / "runs.csv"
        table.write_text("of yesterday", encoding="utf-8")
        writes = ("import sys; sys.path.insert(0, sys.argv[1]); from whole_file import whole_file\n"
                  "with whole_file(sys.argv[2]) as file: file.write('half'); print('open', flush=True); sys.stdin.read()")
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(number), subprocess.Popen([sys.executable, "-B", "-c", writes, TOOLS, table], stdin=subprocess.PIPE,
                                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as started:
                started.stdout.readline()
                started.send_signal(number)
                self.assertEqual(started.wait(PATIENCE_S), -number)
            self.assertEqual(table.read_text(encoding="utf-8"), "of yesterday")
            self.assertEqual(list(self.folder.glob("*.part")), [])

    def test_exit_status_is_of_the_acceptance(self):
        for accept, status in (("locked_pct = 100", 1), ("locked_pct = 1", 0),
                               ("uncontrolled = 0", 0), ("", 0)):
            self.file(f"{MINE}\n[accept]\n{accept}\n")
            self.assertEqual(self.run_mine()[0], status, accept)

    def test_report_repeats_the_summary(self):
        first = self.run_mine(draws=True)
        again = self.called("report", self.mine, "--motorsim", MOTORSIM, "--out", self.folder / "out")
        self.assertEqual((first[0], first[1]), (again[0], again[1]))


class GoingOn(MineTest):
    def test_what_is_there_is_not_run_again_with_more_runs_and_another_acceptance(self):
        self.file(runs=2)
        self.run_mine()
        before = self.lines()
        self.file(f"{MINE}\n[accept]\nlocked_pct = 0\n")
        status, _, err = self.run_mine()
        self.assertEqual(status, 0)
        self.assertEqual(self.lines()[:3], before)
        self.assert_each_once()
        self.assertIn(f"{RUNS} of {RUNS} runs", err)
        _, _, err = self.run_mine()
        self.assertEqual(err, "")

    def test_half_a_line_is_run_again(self):
        self.run_mine()
        expected = self.rows()
        path = self.folder / "out" / "runs.jsonl"
        path.write_bytes(path.read_bytes()[:-10])
        self.run_mine()
        self.assertEqual(self.rows(), expected)

    def test_what_decides_the_results_may_not_differ(self):
        self.run_mine("--runs", 1)
        cases = (("seed = 3", "seed = 4", "seed was 3, is 4"),
                 ("[0.9, 1.1]", "[0.9, 1.2]", r"vary\.plant\.resistance_scale was uniform 0\.9 to "
                  r"1\.1, is uniform 0\.9 to 1\.2"),
                 ("plant.adc_noise_lsb = 1", "", r"set\.plant\.adc_noise_lsb was 1, is none"),
                 ('"campaign"', '"s2_robust"', "scenario was campaign, is s2_robust"))
        for old, new, says in cases:
            self.file(MINE.replace(old, new))
            self.assert_refused(self.run_mine(), rf"runs\.jsonl: cannot be continued: {says}; .*--f")
        self.assertEqual(self.run_mine("--runs", 1, "--fresh")[0], 0)

    def test_nor_may_the_simulator_or_a_data_file(self):
        self.run_mine("--runs", 1)
        program = self.folder / "motorsim"
        program.write_bytes(MOTORSIM.read_bytes() + b"\0")
        program.chmod(0o755)
        self.assert_refused(self.run_mine("--motorsim", program), "the simulator changed; expected")
        own = self.write("own.toml", 'base = "campaign"\n')
        self.file(MINE.replace('"campaign"', '"./own.toml"'))
        self.run_mine("--runs", 1, "--fresh")
        own.write_text('base = "campaign"\ntuning = "published"\n', encoding="utf-8")
        self.assert_refused(self.run_mine(), "the data files changed; expected")

    def test_two_do_not_write_at_once(self):
        self.run_mine("--runs", 1)
        holder = subprocess.Popen(
            [sys.executable, "-c", "import fcntl, sys; f = open(sys.argv[1], 'a'); "
             "fcntl.flock(f, fcntl.LOCK_EX); print('held', flush=True); sys.stdin.read()",
             self.folder / "out" / "runs.jsonl"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        with holder:
            holder.stdout.readline()
            self.assert_refused(self.run_mine(), r"runs\.jsonl: another campaign writes there")
            holder.stdin.close()

    def stopped_of(self, asked_for, *more):
        """Ends the campaign by Ctrl-C once some runs are there: it says of how many, and no more."""
        words = ["run", self.mine, "--motorsim", MOTORSIM, "--out", self.folder / "out", *more]
        path = self.folder / "out" / "runs.jsonl"
        with subprocess.Popen([sys.executable, "-B", TOOLS / "campaign", *words],
                              stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as started:
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end and not (path.exists() and len(self.lines()) > RUNS):
                time.sleep(0.05)
            started.send_signal(signal.SIGINT)
            out, err = started.communicate(timeout=PATIENCE_S)
        self.assertEqual((started.returncode, out), (130, ""))
        self.assertNotIn("Traceback", err)
        done = sum(row["run"] < asked_for for row in self.rows())
        self.assertEqual(err.splitlines()[-1], f"campaign: stopped after {done} of {asked_for} runs; the same command goes on")

    def test_ctrl_c_leaves_what_can_be_gone_on_with(self):
        self.file(runs=5000)
        self.stopped_of(5000)
        count = len(self.rows())
        self.assertGreaterEqual(count, RUNS)
        self.run_mine("--runs", count)
        self.assertEqual([row["run"] for row in self.rows()][:RUNS], list(range(RUNS)))

    def test_ctrl_c_names_the_runs_that_were_asked_for(self):
        self.file(runs=5000)
        self.stopped_of(4000, "--runs", "4000")


class Again(MineTest):
    def test_a_run_again_is_the_row_of_the_campaign(self):
        self.run_mine()
        for row in self.rows():
            done = self.tool("rerun", "--run", row["run"], "--json", "-")
            found = json.loads(done.stdout)
            self.assertEqual({key: found[key] for key in row["metrics"]}, row["metrics"])
            self.assertEqual(done.returncode, 0 if row["outcome"] == "locked" else 1)

    def test_the_command_printed_is_the_run(self):
        trace = self.folder / "t.csv"
        done = self.tool("rerun", "--run", 1, "--trace", trace)
        command = shlex.split(done.stderr.splitlines()[0])
        values = campaign.load(str(self.mine)).values(1)
        self.assertEqual([word for word in command if "=" in word][2:],
                         [f"{key}={text}" for key, text in values.items()])
        again = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(again.stdout, done.stdout)
        self.assertTrue(trace.read_text(encoding="utf-8").startswith("time_s,"))

    def test_every_failure_has_its_command(self):
        self.run_mine()
        lines = (self.folder / "out" / "failures.txt").read_text(encoding="utf-8").splitlines()
        commands = [line for line in lines if not line.startswith("#")]
        failed = [row for row in self.rows() if row["outcome"] != "locked"]
        self.assertEqual(len(commands), len(failed))
        command, said = commands[0].split(OPTION_SEPARATOR)
        done = subprocess.run([*shlex.split(command), "--json", "-"], capture_output=True,
                              text=True, check=False)
        self.assertEqual(json.loads(done.stdout)["failed_limits"],
                         failed[0]["metrics"]["failed_limits"])
        self.assertIn(f"scenario.seed={failed[0]['values']['scenario.seed']}", said)


class Refusals(MineTest):
    def changed(self, old, new):
        self.assertIn(old, MINE)
        self.file(MINE.replace(old, new, 1))
        return self.run_mine()

    def test_what_the_simulator_refuses_is_told_before_the_first_run(self):
        for old, new, says in (
                ("plant.resistance_scale", "plant.resistence_scale",
                 r"plant\.resistence_scale = .*unknown key, did you mean plant\.resistance_scale"),
                ("[0.9, 1.1]", "[0.9, 11]", r"plant\.resistance_scale = 11: is too large; allowed: "
                 r"0\.1 to 10"),
                ("[0, 40]", "[0, 10, 70]", r"bus_ripple_pct = 70: is too large; allowed"),
                ('"campaign"', '"s99"', r'scenario = "s99": not found'),
                ("plant.adc_noise_lsb = 1", 'plant.adc_noise_lsb = "loud"', "adc_noise_lsb = .*all")):
            self.assert_refused(self.changed(old, new), rf"^campaign: .*mine\.toml: .*{says}")
            self.assertFalse((self.folder / "out").exists())

    def test_a_scenario_without_limits_judges_nothing(self):
        self.write("own.toml", 'motor = "motor_a"\nboard = "bench_310v"\ntuning = "robust_motor_a"\n'
                   '[scenario]\ntitle = "t"\nmode = "speed"\nduration_s = 0.1\n')
        self.assert_refused(self.changed('"campaign"', '"./own.toml"'),
                            r"own\.toml has no limits for these .*expected \[accept\.any\]")

    def test_arguments(self):
        for words, says in ((("--motorsim", self.folder / "no"), "no: no program; expected motorsim: run tools/dev build"),
                            (("--motorsim", "/bin/true"), "motorsim: exit status 0, no message; expected a run's results"),
                            (("--scheduler", "nonsense://x"), "--scheduler: nonsense://x: .*; expected the address")):
            self.assert_refused(self.run_mine(*words), says)
        self.assert_refused(self.run_mine(out="mine.toml"), r"mine\.toml.*place to write to")
        for words in (["--runs", "0"], ["--jobs", "x"], ["--jobs", "1", "--scheduler", "a"]):
            self.assertEqual(self.run_mine(*words)[0], 2)
        self.assert_refused(self.called("rerun", self.mine, "--run", RUNS, "--motorsim", MOTORSIM),
                            f"--run {RUNS}: .*0 to {RUNS - 1}")
        self.assert_refused(self.called("report", self.mine, "--out", self.folder / "none"),
                            "No such file.*expected results of")

    def test_results_that_are_none(self):
        (self.folder / "out").mkdir()
        for text, says in (("{}\n", "line 1 is none of"), ("[1\n", ".*expected a line of JSON"),
                           ('{"settings": {}, "files": {}}\n3\n', "line 2 is none of")):
            self.write("out/runs.jsonl", text)
            self.assert_refused(self.run_mine(), rf"runs\.jsonl: {says}")
            self.assertEqual(Path(self.folder / "out/runs.jsonl").read_text("utf-8"), text)

    def test_help_teaches(self):
        for words, said in ((["--help"], ("run robust", "rerun robust --run 1234", "failed safe")),
                            (["run", "--help"], ("log_uniform", "[accept]", "--scheduler")),
                            (["rerun", "--help"], ("--trace", "--run N"))):
            status, out, _ = self.called(*words)
            self.assertEqual(status, 0)
            for word in said:
                self.assertIn(word, out)

    def test_the_list_names_what_there_is(self):
        self.assertRegex(self.called("list")[1], r"robust +2000 runs  parameters off")


if __name__ == "__main__":
    unittest.main()
