"""How hapticd starts, refuses to start, and ends."""
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

import daemon
import hapticd


class Start(unittest.TestCase):
    def refused(self, code, words, *options):
        got, text = daemon.run(*options)
        self.assertEqual(got, code, text)
        for word in words:
            self.assertIn(word, text)

    def test_help_and_version_are_answers_and_no_errors(self):
        self.assertEqual(daemon.run("--help")[0], 0)
        code, text = daemon.run("--version")
        self.assertEqual((code, text.split()[0]), (0, "hapticd"))

    def test_the_help_has_every_exit_code_of_the_man_page(self):
        manual = (pathlib.Path(__file__).resolve().parents[2] / "deploy/man/hapticd.1").read_text(encoding="utf-8")
        codes = re.findall(r"(?:^|; )(\d) ", re.search(r'\.SH "EXIT STATUS"\n(.*?)\n\.B device', manual, re.DOTALL)[1], re.MULTILINE)
        self.assertIn("8", codes)
        self.assertEqual(codes, re.findall(r"(?:: |,\s)(\d) ", daemon.run("--help")[1].split("Exit codes")[1]))

    def test_the_completion_offers_the_devices_that_the_help_lists(self):
        script = pathlib.Path(__file__).parents[2] / "deploy/completion/hapticd"
        bash = f"source {script}; COMP_WORDS=(hapticd --device ''); COMP_CWORD=2; _hapticd {daemon.HAPTICD}; echo ${{COMPREPLY[@]}}"
        offered = subprocess.run(["bash", "-c", bash], stdout=subprocess.PIPE, text=True, timeout=60, check=True).stdout.split()
        self.assertIn("replay:", offered)
        listed = re.search("--device (.*)", daemon.run("--help")[1])[1]
        self.assertEqual(offered, re.sub(r"FILE|\[:SERIAL\]", "", listed).split("|"))

    def test_what_makes_no_sense_is_refused_by_name_and_with_a_remedy(self):
        self.refused(2, ["--rate", "250"], "--rate", "20000")
        self.refused(2, ["--bogus"], "--bogus")
        self.refused(2, ["--device", "simulated"], "--device", "falcon")
        self.refused(2, ["--help"], "--clock", "sundial")
        self.refused(2, ["replay:FILE"], "--device", "replay:")
        self.refused(2, ["is not a whole number"], "--seed", "-1")
        self.refused(2, ["--pace device", "--device hid"], "--pace", "device")
        self.refused(2, ["--pace device", "--device hid"], "--pace", "device", "--device", "spacemouse")
        self.refused(2, ["--clock", "--pace"], "--pace", "device", "--clock", "virtual")

    def test_a_bad_scene_or_gesture_is_told_with_what_there_is(self):
        self.refused(1, ["no scene of this name", "guqin"], "--scene", "no_such_scene")
        self.refused(1, ["no gesture of this name", "demonstration"], "--scene", "sphere", "--gesture", "no_such_gesture")
        self.refused(1, ["string_index"], "--scene", "sphere", "--gesture", "demonstration")

    def test_a_configuration_is_refused_with_file_and_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "my.textproto"
            path.write_text('scene: "sphere"\nrat: 1000\n')
            self.refused(1, [f"{path}:2:", "rat"], "--config", str(path))
            path.write_text('scene: "sphere"\nrate: 20000\n')
            self.refused(2, ["rate"], "--config", str(path))
            self.refused(1, ["is a folder"], "--config", folder)
            path.write_text("")
            self.assertEqual(daemon.run("--config", str(path), "--scene", "sphere", "--check")[0], 0)
        self.refused(1, ["cannot be read"], "--config", "/no/such/file")

    def test_the_command_line_wins_over_the_configuration(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "my.textproto"
            path.write_text('scene: "no_such_scene"\nclock: CLOCK_MODE_VIRTUAL\n')
            code, text = daemon.run("--config", str(path), "--scene", "sphere", "--check")
            self.assertEqual(code, 0, text)

    def test_a_check_refuses_as_the_start_does(self):
        with tempfile.TemporaryDirectory() as folder:
            taken = pathlib.Path(folder) / "taken.mcap"
            taken.touch()
            for code, options in ((3, ("--listen", "x")), (3, ("--listen", "127.0.0.1:99999")), (3, ("--stop-listen", "x")),
                                  (3, ("--stop-listen", "here:1")), (7, ("--record", "/proc/x.mcap")), (7, ("--record", str(taken)))):
                where = () if options[0] == "--listen" else ("--listen", "127.0.0.1:0")
                for check in ((), ("--check",)):
                    self.refused(code, [options[0]], "--scene", "sphere", *where, *options, *check)
            config = pathlib.Path(folder) / "my.textproto"
            config.write_text('scene: "sphere"\nlisten: "x"\n')
            self.refused(3, ["--listen"], "--config", str(config), "--check")
            new = pathlib.Path(folder) / "new/take.mcap"
            self.assertEqual(daemon.run("--scene", "sphere", "--record", str(new), "--check")[0], 0)
            self.assertFalse(new.parent.exists())

    def test_a_check_opens_no_device(self):
        for source in ("hid", "pid:S1", "spacemouse"):
            code, text = daemon.run("--scene", "sphere", "--device", source, "--check")
            self.assertEqual(code, 0, text)

    def test_an_address_in_use_or_beyond_loopback_is_refused(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("127.0.0.1", 0))
            self.refused(3, ["--listen"], "--scene", "sphere", "--listen", f"127.0.0.1:{other.getsockname()[1]}")
        self.refused(3, ["--listen"], "--scene", "sphere", "--listen", "0.0.0.0:0")

    def test_sigterm_fades_the_force_says_goodbye_and_ends_with_0(self):
        with daemon.Daemon("--scene", "single_string") as played:
            with hapticd.Session(played.address, reconnect=False) as session:
                session.subscribe(divisor=10, sections=["TOOLS"])
                list(session.states(5))
                self.assertEqual(played.end(signal.SIGTERM), 0, played.log)
        self.assertIn("loop state ENGAGED -> RELEASING", played.log)
        self.assertIn("loop state RELEASING -> OVER", played.log)


    def test_scenes_are_exchanged_while_every_tick_of_a_fast_loop_is_told(self):
        # At 4 kHz the loop is ticks ahead of the network thread: it hears of the exchange before it has told the last ticks of the old scene.
        with daemon.Daemon("--scene", "wall", "--rate", "4000") as played, hapticd.Session(played.address) as session:
            session.subscribe(divisor=1, sections=["TOOLS"])
            session.acquire("test")
            for k in range(10):
                session.load_scene("wall" if k % 2 else "sphere")
                list(session.states(20))
            self.assertEqual(session.scene.scene.name, "wall")
            self.assertEqual(played.end(), 0, played.log)

    def test_sighup_loads_the_scene_of_the_configuration_anew(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "my.textproto"
            path.write_text('scene: "single_string"\n')
            with daemon.Daemon("--config", str(path)) as played, hapticd.Session(played.address) as session:
                self.assertEqual(session.scene.scene.name, "single_string")
                session.subscribe(divisor=20, sections=["TOOLS"])
                list(session.states(5))
                path.write_text('scene: "sphere"\n')
                played.process.send_signal(signal.SIGHUP)
                while session.scene.scene.name != "sphere":
                    list(session.states(1))
                # What cannot be read changes nothing.
                path.write_text('scne: "wall"\n')
                played.process.send_signal(signal.SIGHUP)
                list(session.states(20))
                self.assertEqual(session.scene.scene.name, "sphere")
                self.assertEqual(played.end(), 0, played.log)
            self.assertIn(f"{path}:1:", played.log)


    def test_sighup_changes_what_a_client_could_and_names_what_waits_for_the_next_start(self):
        with tempfile.TemporaryDirectory() as folder:
            # Confined, it reaches no other folder of which the start knows nothing.
            path, recording = pathlib.Path(folder) / "my.textproto", pathlib.Path(folder) / "hapticd" / "session.mcap"
            path.write_text('scene: "wall"\nquality: "1"\n')
            with daemon.Daemon("--config", str(path), "--rate", "500", state=folder) as played, hapticd.Session(played.address) as session:
                session.subscribe(divisor=10, sections=["QUALITY"])
                self.assertEqual(list(session.states(3))[-1].quality.level, 1)
                before = session.scene.scene_id
                path.write_text(f'scene: "wall"\nquality: "4"\nrate: 1000\ncpu: 0\nrecord: "{recording}"\n')
                played.process.send_signal(signal.SIGHUP)
                # A State may come before the news of its scene.
                while session.latest.quality.level != 4 or session.scene.scene_id == before:
                    list(session.states(1))
                self.assertEqual(session.scene.rate_hz, 500.0)
                path.write_text('scene: "wall"\n')
                played.process.send_signal(signal.SIGHUP)
                while session.latest.quality.level != 3:
                    list(session.states(1))
                self.assertEqual(played.end(), 0, played.log)
            # The command line has the rate; the processor is the file's, and of the start.
            self.assertIn("takes effect at the next start only: cpu\n", played.log)
            magic = b"\x89MCAP0\r\n"
            recorded = recording.read_bytes()
            self.assertTrue(recorded.startswith(magic) and recorded.endswith(magic))


class Playing(unittest.TestCase):
    def test_started_with_nothing_but_a_port_it_plays_the_guqin(self):
        with daemon.Daemon() as played, hapticd.Session(played.address) as session:
            self.assertEqual(session.scene.scene.name, "guqin")
            session.subscribe(divisor=20, sections=["TOOLS", "GESTURES"])
            tone = None
            while tone is None:
                list(session.states(10))
                for event in session.events(timeout=0):
                    tone = event if event.kind == "tone" else tone
            self.assertGreater(tone.body.frequency_hz, 0.0)
            self.assertEqual(session.latest.gestures[0].name, "demonstration")

    def test_a_session_is_recorded_and_the_file_is_whole(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "session.mcap"
            with daemon.Daemon("--scene", "single_string", "--record", str(path)) as played:
                with hapticd.Session(played.address) as session:
                    session.subscribe(divisor=10, sections=["TOOLS"])
                    list(session.states(30))
                self.assertEqual(played.end(), 0, played.log)
            magic = b"\x89MCAP0\r\n"
            recorded = path.read_bytes()
            self.assertTrue(recorded.startswith(magic) and recorded.endswith(magic))

    def test_stop_leaves_a_dump_of_the_last_60_s_and_clear_goes_on(self):
        with tempfile.TemporaryDirectory() as folder:
            with daemon.Daemon("--scene", "single_string", state=folder) as played, hapticd.Session(played.address) as session:
                session.acquire("test")
                session.subscribe(divisor=10, sections=["TOOLS"])
                list(session.states(10))
                session.stop()
                self.assertEqual(list(session.states(3))[-1].loop_state, hapticd.v1.state_pb2.LOOP_STATE_FAULT)
                session.clear()
                while session.latest.loop_state != hapticd.v1.state_pb2.LOOP_STATE_ENGAGED:
                    list(session.states(5))
                names = list(session.recordings())
            self.assertEqual([name.startswith("fault-") for name in names], [True])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
