#!/usr/bin/env python3
"""rigcald and its command line, as an operator meets them, on a simulated studio of one small camera: the first calibration,
recalibration, replay byte for byte as offline, publishing, cancelling, SIGHUP, SIGKILL, and requests that are wrong. Waits for
events, never for a time. service.py --rigcal BIN --rigcald BIN --openapi FILE"""
import argparse
import http.client
import json
import os
import pathlib
import queue
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time

HANG_S = 120  # far beyond what anything here takes
BOARD = 'family = "tag36h11"\ncolumns = 4\nrows = 3\ntag_m = 0.036\ngap_m = 0.011\nthickness_m = 0.005\n'
RIG = """[positioner]
kind = "turntable"
driver = "sim"
settle_s = 0
[[positioner.axis]]
speed_deg_s = {speed}
[stops]
count = 12
[sim]
width_px = 400
height_px = 300
[chart]
board = "board.toml"
[publish]
rig = "studio"
formats = ["opencv"]
"""
FAST, SLOW = 720, 0.1  # at the slow one the second stop is minutes away
QUICK = ["--rounds", "1", "--expected-error-px", "4"]


class Connection(http.client.HTTPConnection):
    """HTTP over the service's socket."""

    def __init__(self, path):
        super().__init__("localhost", timeout=HANG_S)
        self.socket_path = str(path)

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(HANG_S)
        self.sock.connect(self.socket_path)


def listen_to(line, notices):
    while True:
        notices.put(line.recv(4096).decode())


class Bench:
    def __init__(self, args, root):
        self.rigcal, self.rigcald = os.path.abspath(args.rigcal), os.path.abspath(args.rigcald)
        self.root, self.failures = root, 0
        self.openapi = json.loads(pathlib.Path(args.openapi).read_text())
        self.state, self.socket = root / "state", root / "s.sock"
        self.environment = dict(os.environ, RIGCAL_SOCKET=str(self.socket), RIGCAL_RUN_DIR=str(root / "run"))
        (root / "board.toml").write_text(BOARD)
        self.write_rig(FAST)
        self.log = open(root / "log", "w+")
        self.daemon = None
        (root / "token").write_text("0123456789abcdef\n")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                        "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-keyout", str(root / "key.pem"), "-out",
                        str(root / "cert.pem")], check=True, capture_output=True, timeout=HANG_S)
        self.listen = ["--listen", "127.0.0.1:0", "--token-file", str(root / "token"), "--tls-certificate", str(root / "cert.pem"),
                       "--tls-key", str(root / "key.pem")]

    def write_rig(self, speed):
        (self.root / "rig.toml").write_text(RIG.format(speed=speed))

    def check(self, name, good, what=""):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name} {str(what).strip()}", flush=True)

    def start(self):
        """Starts the service and waits until it says that it is ready."""
        line, self.notices = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM), queue.Queue()
        path = self.root / "notify"
        path.unlink(missing_ok=True)
        line.bind(str(path))
        threading.Thread(target=listen_to, args=(line, self.notices), daemon=True).start()  # a full line would hold the service up
        self.daemon = subprocess.Popen(
            [self.rigcald, "--config", str(self.root / "rig.toml"), "--state", str(self.state), "--threads", "2", *self.listen],
            env=dict(self.environment, NOTIFY_SOCKET=str(path), WATCHDOG_USEC="3000000"), stderr=self.log)
        self.told("READY=1")

    def told(self, word):
        while word not in self.notices.get(timeout=HANG_S):
            pass

    def stop(self, how=signal.SIGTERM):
        self.daemon.send_signal(how)
        return self.daemon.wait(timeout=HANG_S)

    def run(self, *words):
        return subprocess.run([self.rigcal, *map(str, words)], capture_output=True, text=True, timeout=HANG_S, env=self.environment,
                              cwd=self.root)

    def store(self, *words):
        return self.run(*words, "--state", self.state)

    def ask(self, method, path, body=None, headers=()):
        connection = Connection(self.socket)
        connection.request(method, path, body, dict(headers))
        reply = connection.getresponse()
        text = reply.read().decode()
        connection.close()
        return reply.status, text

    def get(self, path):
        return json.loads(self.ask("GET", path)[1])

    def job(self, number):
        return self.get(f"/api/v1/jobs/{number}")

    def follow(self, number, until):
        """The first of a job's events that `until` holds for."""
        connection = Connection(self.socket)
        connection.request("GET", f"/api/v1/jobs/{number}/events")
        reply = connection.getresponse()
        found = None
        while line := reply.readline().decode():
            if line.startswith("data: ") and until(job := json.loads(line[6:])):
                found = job
                break
        connection.close()
        return found


def seeded(bench):
    nothing = bench.run("recalibrate", "--wait")
    bench.check("nothing to begin with", nothing.returncode == 1 and "seed-chart" in nothing.stdout, nothing.stdout + nothing.stderr)
    done = bench.run("seed-chart", "--wait")
    bench.check("seed-chart", done.returncode == 0 and "revision 1: accepted" in done.stdout, done.stdout + done.stderr)
    current = json.loads((bench.state / "published/current.json").read_text())
    bench.check("published", current["revision"]["number"] == 1 and (bench.state / "published/opencv.yml").exists())
    bench.check("by the job", "rigcald job 2 (seed-chart) for " in current["revision"]["published_by"])
    text = bench.run("status").stdout
    bench.check("status", "rig 'studio'" in text and "revision 1 is in force" in text and "no job runs" in text, text)


def refined(bench):
    """The chart alone leaves this one camera's principal point open, so that the first refinement moves it too far."""
    done = bench.run("recalibrate", "--wait", *QUICK)
    bench.check("recalibrate", done.returncode == 3 and "revision 2: rejected" in done.stdout, done.stdout + done.stderr)
    bench.check("the pointer stays", bench.get("/api/v1/calibrations")["in_force"] == 1)
    status, text = bench.ask("POST", "/api/v1/calibrations/2/publish", json.dumps({"expected": 1, "by": "anna", "reason": "by hand"}))
    bench.check("a person publishes it", status == 200, text)
    status, text = bench.ask("POST", "/api/v1/calibrations/1/publish", json.dumps({"expected": 1}))
    bench.check("who comes late is told", status == 409 and "revision 2 is in force, not 1" in text, text)
    recording = bench.job(3)["recording"]
    done = bench.run("replay", recording, "--wait", "--json", *QUICK)
    bench.check("replay", done.returncode == 0 and json.loads(done.stdout)["outcome"]["revision"] == 3, done.stdout + done.stderr)
    bench.check("published by itself", bench.get("/api/v1/calibrations")["in_force"] == 3)
    (bench.root / "calibration.json").write_text(bench.store("show", 2, "--calibration").stdout)
    bench.run("refine", "--recording", recording, "--cameras", "calibration.json", "--out", "offline", "--threads", 1, *QUICK)
    same = all((bench.root / f"offline/{name}.json").read_text() == bench.store("show", 3, f"--{name}").stdout
               for name in ("calibration", "report"))
    bench.check("the same bytes as offline", same)


def history(bench):
    text = bench.store("history").stdout
    bench.check("history", "*     3" in text and "publish 2 -> 3 by rigcald job 4 (replay)" in text, text)
    text = bench.store("diff", 1, 3).stdout
    bench.check("diff", "revision 1" in text and "cam0" in text, text)
    done = bench.run("rollback", "--reason", "too warm")
    current = json.loads((bench.state / "published/current.json").read_text())
    bench.check("rollback", done.returncode == 0 and current["revision"]["number"] == 2 and "rollback 3 -> 2" in done.stdout, done)
    late = bench.run("publish", 3, "--expected", 3)
    bench.check("publish comes late", late.returncode == 2 and "revision 2 is in force, not 3" in late.stderr, late.stderr)
    shown = bench.run("job", 3).stdout
    bench.check("job", "job 3 (recalibrate): done: revision 2: rejected" in shown, shown)
    bench.check("jobs", bench.run("jobs").stdout.count("job ") == 4)


def views_of(job):
    return json.loads((pathlib.Path(job["recording"]) / "recording.json").read_text())["views"]


def slow_job(bench):
    """A job that stands between two stops, the picture of the first one stored; its number, and how it stands."""
    number = json.loads(bench.run("recalibrate", "--json").stdout)["id"]
    job = bench.follow(number, lambda job: job["progress"] and "stop 2 of 12: moving" in job["progress"]["text"])
    deadline = time.monotonic() + HANG_S
    while job and not views_of(job) and time.monotonic() < deadline:
        time.sleep(0.05)
    return number, job


def cancelled(bench):
    bench.write_rig(SLOW)
    bench.daemon.send_signal(signal.SIGHUP)
    bench.told("RELOADING=1")
    bench.told("READY=1")
    number, job = slow_job(bench)
    bench.check("reloaded by SIGHUP", job is not None)
    second = json.loads(bench.run("capture", "--what", "object", "--json").stdout)["id"]
    bench.check("one waits", bench.get("/api/v1/status")["num_waiting"] == 1)
    bench.check("cancelled in the queue", bench.run("cancel", second).returncode == 0 and bench.job(second)["state"] == "cancelled")
    bench.run("cancel", number)
    bench.run("watch", number)
    job = bench.job(number)
    kept = json.loads((pathlib.Path(job["recording"]) / "recording.json").read_text())
    bench.check("cancelled while it ran", job["state"] == "cancelled" and not kept["closed"] and len(kept["views"]) == 1, job)
    again = bench.run("cancel", number)
    bench.check("cancelled twice", again.returncode == 2 and "ended already" in again.stderr, again.stderr)
    held = bench.run("capture", "--rig", "rig.toml", "--out", "own")
    bench.check("the rig is held", held.returncode == 2 and "ask it with: rigcal capture" in held.stderr, held.stderr)


def killed(bench):
    number, job = slow_job(bench)
    pictures = {path.name: path.read_bytes() for path in pathlib.Path(job["recording"]).glob("*.png")}
    bench.stop(signal.SIGKILL)
    gone = bench.run("status")
    bench.check("nobody answers", gone.returncode == 1 and "no service answers" in gone.stderr and str(bench.socket) in gone.stderr)
    (bench.state / "published/current.json").unlink()
    bench.write_rig(FAST)
    bench.start()
    after = bench.job(number)
    bench.check("interrupted", after["state"] == "interrupted" and after["recording"] == job["recording"], after)
    bench.check("what is published is mended", (bench.state / "published/current.json").exists())
    bench.check("the recording is kept", len(pictures) == 1 and
                all((pathlib.Path(job["recording"]) / name).read_bytes() == data for name, data in pictures.items()))
    told = bench.run("job", number).stdout
    bench.check("how to go on", f"rigcal recalibrate --recording {job['recording']}" in told, told)
    done = bench.run("recalibrate", "--recording", job["recording"], "--wait", *QUICK)
    bench.check("gone on with", done.returncode in (0, 3) and "revision 4" in done.stdout, done.stdout + done.stderr)
    bench.check("the store is whole", "nothing is wrong" in bench.store("store", "check").stdout)


def bad_rig_file(bench):
    (bench.root / "rig.toml").write_text("[positioner]\nkind = \"wheel\"\n")
    bench.daemon.send_signal(signal.SIGHUP)
    bench.told("RELOADING=1")
    bench.told("READY=1")
    bench.check("a bad rig file leaves the old one", bench.get("/api/v1/status")["rig"]["positioner_driver"] == "sim")
    bench.write_rig(FAST)


def bad_requests(bench):
    for name, method, path, body, status, words in (
            ("huge body", "POST", "/api/v1/jobs", "x" * 100_000, 413, "too large"),
            ("bad JSON", "POST", "/api/v1/jobs", "{", 400, "no JSON"),
            ("no kind", "POST", "/api/v1/jobs", "{}", 400, "no kind of job"),
            ("path tricks", "GET", "/api/v1/../../etc/passwd", None, 404, "there is no"),
            ("encoded tricks", "GET", "/api/v1/jobs/%2e%2e%2f1", None, 404, "there is no"),
            ("wrong method", "DELETE", "/api/v1/jobs", None, 405, "does not answer DELETE")):
        seen, text = bench.ask(method, path, body)
        bench.check(name, seen == status and words in json.loads(text)["error"]["message"], f"{seen} {text}")
    line = socket.socket(socket.AF_UNIX)
    line.settimeout(HANG_S)
    line.connect(str(bench.socket))
    line.sendall(b"POST /api/v1/jobs HTTP/1.1\r\nContent-Length: 1000\r\n\r\n{")  # and no more
    bench.check("a slow sender holds nobody up", bench.ask("GET", "/healthz")[0] == 200)
    line.close()
    noise = socket.socket(socket.AF_UNIX)
    noise.settimeout(HANG_S)
    noise.connect(str(bench.socket))
    noise.sendall(b"\x00\xff nothing\r\n\r\n")
    bench.check("noise", b" 400 " in noise.recv(4096).split(b"\r\n")[0])
    noise.close()
    nowhere = bench.run("replay", "nowhere", "--wait")
    bench.check("no recording", nowhere.returncode == 1 and "there is no recording" in nowhere.stdout, nowhere.stdout + nowhere.stderr)
    bench.check("no job", bench.run("job", 999).returncode == 2)
    second = subprocess.run([bench.rigcald, "--config", str(bench.root / "rig.toml"), "--state", str(bench.root / "other")],
                            capture_output=True, text=True, timeout=HANG_S, env=bench.environment)
    bench.check("a second service", second.returncode == 1 and "held by process" in second.stderr, second.stderr)
    bench.check("socket's mode", (bench.socket.stat().st_mode & 0o777) == 0o660)


def by_network(bench):
    lines = (bench.root / "log").read_text().splitlines()
    port = int([line for line in lines if "answers at https://127.0.0.1:" in line][-1].rsplit(":", 1)[1])
    def ask(path, **headers):
        context = ssl.create_default_context(cafile=bench.root / "cert.pem")
        connection = http.client.HTTPSConnection("localhost", port, timeout=HANG_S, context=context)
        connection.request("GET", path, headers=headers)
        reply = connection.getresponse()
        text = reply.read().decode()
        connection.close()
        return reply.status, text
    bench.check("by TLS, with the token", ask("/api/v1/status", Authorization="Bearer 0123456789abcdef")[0] == 200)
    for name, headers in (("without a token", {}), ("wrong token", {"Authorization": "Bearer 0123456789abcdeF"})):
        status, text = ask("/api/v1/status", **headers)
        bench.check(name, status == 401 and "no token" in json.loads(text)["error"]["message"], text)
    bench.check("health needs none", ask("/healthz")[0] == 200)


def documented(bench):
    """Every path of the document answers, and says what the document says that it does."""
    for path, operations in bench.openapi["paths"].items():
        for method, operation in operations.items():
            real = path.replace("{id}", "1").replace("{revision}", "1") + ("?before=1&after=2" if path.endswith("diff") else "")
            if path.endswith("/events") or method == "post":
                status, text = bench.ask(method.upper(), real.replace("/1/", "/999/"), "{}" if method == "post" else None)
            else:
                status, text = bench.ask(method.upper(), real)
            bench.check(f"{method} {path}", str(status) in operation["responses"], f"{status} {text[:80]}")


def ended(bench):
    status = bench.stop()
    bench.check("stopped", status == 0 and not bench.socket.exists(), status)
    bench.log.seek(0)
    lines = bench.log.read().splitlines()
    once = sum("job 3 (recalibrate) is done: revision 2: rejected" in line for line in lines)
    bench.check("each end is logged once", once == 1, "\n".join(lines) if bench.failures else "")


def main():
    parser = argparse.ArgumentParser()
    for option in ("--rigcal", "--rigcald", "--openapi"):
        parser.add_argument(option, required=True)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal_service_") as root:
        bench = Bench(args, pathlib.Path(root))
        try:
            bench.start()
            for part in (seeded, refined, history, cancelled, killed, bad_rig_file, bad_requests, by_network, documented, ended):
                part(bench)
        finally:
            if bench.daemon and bench.daemon.poll() is None:
                bench.daemon.kill()
                bench.daemon.wait()
            if bench.failures:
                bench.log.seek(0)
                print(bench.log.read())
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
