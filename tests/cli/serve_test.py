"""The planner's server: who may talk to it, what it refuses, and that no job is lost.
Usage: serve_test.py PROGRAM"""
import http.client
import io
import json
import os
import pathlib
import signal
import socket
import ssl
import stat
import subprocess
import tempfile
import time
import unittest
import warnings
import zipfile

from dicom_files import Series
from scan_only_test import write_scan
from sanatrix_cli import (CliTest, ENVIRONMENT, QUICK, binary, main, outcome_of, sanatrix,
                          write_patient)

MARKUP = "<img src=x onerror=alert(1)>"
QUICK_SET = {word.split("=")[0]: word.split("=")[1] for word in QUICK if "=" in word}


def zipped(files, method=zipfile.ZIP_DEFLATED):
    """A zip file of {name or ZipInfo: bytes}, or of pairs when a name comes twice."""
    memory = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(memory, "w", method) as archive:
        warnings.simplefilter("ignore")
        for name, content in (files.items() if isinstance(files, dict) else files):
            archive.writestr(name, content)
    return memory.getvalue()


class Server:
    """`sanatrix serve` on a free port, and a client that is let in."""

    def __init__(self, cases):
        self.process = subprocess.Popen(
            [binary(), "serve", "--cases", str(cases), "--port", "0", "--json"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=ENVIRONMENT, text=True)
        self.address = json.loads(self.process.stdout.readline())["address"]
        self.port = int(self.address.split(":")[2].split("/")[0])
        self.cookie, self.proof = "", ""
        started = self.ask("GET", self.address.split(str(self.port))[1], headers={})
        self.cookie = started.headers["Set-Cookie"].split(";")[0]
        self.proof = json.loads(self.ask("GET", "/api/session").body)["proof"]

    def ask(self, method, path, body=None, headers=None, timeout=60):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        sent = {"Cookie": self.cookie, "X-Sanatrix-Proof": self.proof} if headers is None else headers
        connection.request(method, path, body, sent)
        answer = connection.getresponse()
        answer.body = answer.read()
        connection.close()
        return answer

    def json(self, method, path, body=None):
        answer = self.ask(method, path, None if body is None else json.dumps(body))
        if answer.status >= 300:
            raise AssertionError(f"{method} {path}: {answer.status} {answer.body[:300]}")
        return json.loads(answer.body)

    def memory_mb(self):
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
        raise AssertionError("the server is gone")

    def cpu_ms(self):
        """What the server itself has computed, without its children."""
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return 1e3 * (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def upload(self, files):
        """One upload of [(name, bytes)]."""
        batch = ""
        for name, content in files:
            answer = self.ask("POST", f"/api/uploads?name={name}&batch={batch}", content)
            batch = json.loads(answer.body)["upload"]
        return batch

    def health_ms(self):
        start = time.monotonic()
        status = self.ask("GET", "/api/session").status
        assert status == 200, status
        return 1e3 * (time.monotonic() - start)

    def raw(self, data, wait=5.0):
        """Sends bytes as they are; returns what comes back."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=wait) as s:
            try:
                s.sendall(data)
                received = b""
                while piece := s.recv(65536):
                    received += piece
                return received
            except (ConnectionError, TimeoutError):
                return b""

    def wait_for(self, job, states=("done", "failed", "cancelled"), seconds=600):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            found = next(j for j in self.json("GET", "/api/jobs")["jobs"] if j["id"] == job)
            if found["state"] in states:
                return found
            time.sleep(0.1)
        raise AssertionError(f"job {job} did not end: {found}")

    def stop(self, how=signal.SIGINT):
        self.process.send_signal(how)
        self.process.wait(60)
        self.process.stdout.close()


class Refuses(CliTest):
    @classmethod
    def setUpClass(cls):
        cls._folder_of_class = tempfile.TemporaryDirectory()
        cls.cases = pathlib.Path(cls._folder_of_class.name) / "cases"
        cls.server = Server(cls.cases)

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        cls._folder_of_class.cleanup()

    def status(self, method, path, headers):
        return self.server.ask(method, path, "{}" if method != "GET" else None, headers).status

    def let_in(self, **more):
        return {"Cookie": self.server.cookie, "X-Sanatrix-Proof": self.server.proof, **more}

    def test_another_host_name_is_refused_so_that_dns_rebinding_fails(self):
        for host in ("evil.example", f"evil.example:{self.server.port}", "127.0.0.1", ""):
            self.assertEqual(self.status("GET", "/api/cases", self.let_in(Host=host)), 421, host)
        two = (f"GET /api/cases HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\n"
               f"Host: evil\r\nCookie: {self.server.cookie}\r\n\r\n")
        self.assertIn(b" 400 ", self.server.raw(two.encode()).split(b"\r\n")[0])

    def test_another_origin_is_refused(self):
        for origin in ("http://evil.example", "null", f"https://127.0.0.1:{self.server.port}"):
            self.assertEqual(self.status("POST", "/api/cases", self.let_in(Origin=origin)), 403)
        crossing = self.let_in(**{"Sec-Fetch-Site": "cross-site"})
        self.assertEqual(self.status("GET", "/api/cases", crossing), 403)
        self.assertEqual(self.status("GET", "/api/events", crossing), 403)

    def test_without_the_cookie_or_the_proof_nothing_is_told_or_changed(self):
        self.assertEqual(self.status("GET", "/api/cases", {}), 401)
        wrong = {"Cookie": self.server.cookie[:-1] + "x"}
        self.assertEqual(self.status("GET", "/api/cases", wrong), 401)
        self.assertEqual(self.status("POST", "/api/cases", {"Cookie": self.server.cookie}), 403)
        self.assertEqual(self.status("GET", "/start?key=" + 32 * "0", {}), 401)

    def test_every_answer_carries_the_protecting_headers(self):
        for path in ("/", "/api/cases", "/api/nothing"):
            headers = self.server.ask("GET", path).headers
            self.assertIn("default-src 'self'", headers["Content-Security-Policy"])
            self.assertNotIn("unsafe", headers["Content-Security-Policy"])
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertEqual(headers["Cache-Control"], "no-store")
            self.assertIsNone(headers["Access-Control-Allow-Origin"])
        cookie = self.server.ask("GET", self.server.address.split(str(self.server.port))[1], headers={})
        self.assertIn("HttpOnly; SameSite=Strict", cookie.headers["Set-Cookie"])

    def test_no_path_leaves_the_cases(self):
        (self.cases / "secret.txt").write_text("secret")
        for path in ("/../secret.txt", "/api/cases/..%2f..%2fetc", "/%2e%2e/%2e%2e/etc/passwd",
                     "/api/cases/.planner/plan", "/api/cases/a%00b", "/assets/../../etc/passwd",
                     "/api/cases/x/files/90-outcome/..%2f..%2fcase.json"):
            answer = self.server.ask("GET", path)
            self.assertIn(answer.status, (400, 404), path)
            self.assertNotIn(b"root:", answer.body)

    def test_symbolic_links_are_not_followed(self):
        outside = self.folder / "outside"
        outside.mkdir()
        (outside / "case.json").write_text("{}")
        (self.cases / "link").symlink_to(outside)
        self.addCleanup((self.cases / "link").unlink)
        self.assertEqual(self.server.ask("GET", "/api/cases/link").status, 400)
        self.assertNotIn(b'"link"', self.server.ask("GET", "/api/cases").body)
        case = self.cases / "posted"
        (case / "stages/90-outcome").mkdir(parents=True)
        (case / "case.json").write_text(json.dumps(
            {"format": "sanatrix-case", "version": 1, "pseudonym": "p", "label_preset": "sanatrix",
             "inputs": {}, "parameters": {}}))
        (case / "stages/90-outcome/passwd").symlink_to("/etc/passwd")
        (case / "stages/90-outcome/stage.json").write_text(
            json.dumps({"files": ["passwd", "../../case.json", "/etc/passwd"]}))
        for file in ("passwd", "..%2f..%2fcase.json", "%2fetc%2fpasswd"):
            answer = self.server.ask("GET", f"/api/cases/posted/files/90-outcome/{file}")
            self.assertEqual(answer.status, 400, file)

    def test_large_bodies_end_early_and_memory_stays_flat(self):
        before = self.server.memory_mb()
        head = (f"POST /api/cases HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\n"
                f"Cookie: {self.server.cookie}\r\nX-Sanatrix-Proof: {self.server.proof}\r\n")
        declared = self.server.raw((head + "Content-Length: 300000000\r\n\r\n").encode() + 4096 * b"x")
        self.assertIn(b" 413 ", declared.split(b"\r\n")[0])
        sent = 0
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=10) as s:
            s.sendall((head + "Transfer-Encoding: chunked\r\n\r\n").encode())
            piece = b"10000\r\n" + 65536 * b"x" + b"\r\n"
            try:
                for _ in range(300_000_000 // 65536):
                    s.sendall(piece)
                    sent += 65536
            except OSError:
                pass  # the server has hung up, as it should
        self.assertLess(sent, 20_000_000)
        self.assertLess(self.server.memory_mb() - before, 30)
        self.assertLess(self.server.health_ms(), 1000)

    def test_large_headers_and_garbage_are_refused(self):
        host = f"Host: 127.0.0.1:{self.server.port}\r\n"
        big = self.server.raw(f"GET / HTTP/1.1\r\n{host}X: {'a' * 100_000}\r\n\r\n".encode())
        self.assertTrue(big == b"" or b" 431 " in big.split(b"\r\n")[0], big[:80])
        self.assertIn(b" 400 ", self.server.raw(b"\x16\x03\x01 hello\r\n\r\n").split(b"\r\n")[0])
        negative = (f"POST /api/cases HTTP/1.1\r\n{host}Cookie: {self.server.cookie}\r\n"
                    f"X-Sanatrix-Proof: {self.server.proof}\r\nTransfer-Encoding: chunked\r\n\r\n-2\r\n")
        self.assertIn(b" 400 ", self.server.raw(negative.encode()).split(b"\r\n")[0])

    def test_a_thousand_idle_connections_and_slow_headers_do_not_keep_others_out(self):
        before, open_ones = self.server.memory_mb(), []
        try:
            for i in range(1000):
                s = socket.create_connection(("127.0.0.1", self.server.port), timeout=5)
                s.sendall(b"GET / HTTP/1.1\r\n" if i % 2 else b"")
                open_ones.append(s)
            slowest = 0.0
            for _ in range(5):
                for s in open_ones[-64:]:  # headers that never end, a byte at a time
                    try:
                        s.send(b"x")
                    except OSError:
                        pass  # closed to make room
                slowest = max(slowest, self.server.health_ms())
            print(f"health under 1000 idle connections: {slowest:.0f} ms at most", flush=True)
            self.assertLess(slowest, 2000)  # 100 ms on a quiet machine; CI shares its cores
            self.assertLess(self.server.memory_mb() - before, 30)
        finally:
            for s in open_ones:
                s.close()

    def test_uploads_keep_nothing_of_the_name_they_had(self):
        answer = self.server.ask("POST", "/api/uploads?name=Jane_Doe_1970.nii.gz", b"not an image")
        folder = self.cases / ".planner/uploads" / json.loads(answer.body)["upload"]
        self.assertEqual(len(list(folder.iterdir())), 1)
        self.assertNotIn("Jane", str(list(folder.iterdir())[0]))
        for name in ("..%2f..%2fx.nii.gz", "x%2fy.sh"):
            answer = self.server.ask("POST", f"/api/uploads?name={name}", b"data")
            self.assertEqual(answer.status, 201)
        self.assertEqual(list(self.cases.rglob("*.sh")), [])

    def test_names_of_scans_are_kept_only_when_they_say_nothing(self):
        upload = self.server.upload([("scan.obj", b"v"), ("material-1.mtl", b"m"), ("her.jpg", b"j"),
                                     ("picture-1.jpg", b"j"), ("scan.obj.exe", b"x")])
        names = {p.name for p in (self.cases / ".planner/uploads" / upload).iterdir()}
        self.assertEqual(len(names), 5)
        self.assertLess({"scan.obj", "material-1.mtl", "picture-1.jpg"}, names)
        self.assertFalse(names & {"her.jpg", "scan.obj.exe"})

    def test_a_dicom_upload_tells_its_series_before_a_case_is_made(self):
        study = self.folder / "study"
        stack = Series(lambda x, y, z: 1, slices=24)
        stack.write(study / "a")
        scout = Series(lambda x, y, z: 1, slices=3, spacing=40.0)
        scout.number, scout.uid = 1, "1.2.3.100"
        scout.write(study / "b")
        files = sorted(study.rglob("*.dcm"))
        as_folder = self.server.upload([("x.dcm", f.read_bytes()) for f in files])
        packed = zipped({str(f.relative_to(study)): f.read_bytes() for f in files})
        for upload in (as_folder, self.server.upload([("study.zip", packed)])):
            told = self.server.json("GET", f"/api/uploads/{upload}/series")
            self.assertEqual([s["chosen"] for s in told["series"]], [False, True])
            self.assertIn("localizer", told["series"][0]["not_chosen_because"])
        # What was chosen by hand reaches `new`, which says why it is a bad choice.
        made = self.server.json("POST", "/api/cases", {"name": "by-hand", "image": as_folder, "series": 9})
        job = self.server.wait_for(made["job"])
        self.assertEqual((job["state"], job["step"]), ("failed", 0))
        self.assertIn("series", job["message"])
        for hostile in (zipped({"../x.dcm": b"x"}), b"no image at all"):
            upload = self.server.upload([("x.zip", hostile)])
            answer = self.server.ask("GET", f"/api/uploads/{upload}/series")
            self.assertEqual(answer.status, 400)
            self.assertNotIn(str(self.cases), answer.body.decode())
        self.assertEqual(self.server.ask("GET", "/api/uploads/..%2f..%2fetc/series").status, 404)
        self.assertEqual(self.server.ask("GET", f"/api/uploads/{32 * '0'}/series").status, 400)

    def fate_of(self, archive, name):
        """What becomes of a case whose image is this zip file; nothing may appear anywhere."""
        before = sorted(p for p in self.cases.rglob("*") if ".planner" not in p.parts)
        answer = self.server.ask("POST", "/api/uploads?name=x.zip", archive)
        upload = json.loads(answer.body)["upload"]
        made = self.server.json("POST", "/api/cases", {"name": name, "image": upload})
        job = self.server.wait_for(made["job"])
        self.assertEqual(job["state"], "failed")
        after = sorted(p for p in self.cases.rglob("*") if ".planner" not in p.parts)
        self.assertEqual(before, after, "nothing is left behind")
        return job["message"]

    def test_hostile_archives_are_refused_and_leave_nothing(self):
        memory = self.server.memory_mb()
        for name in ("ok/../../../escaped.nii", "/tmp/sanatrix-escaped.nii", "a\\..\\..\\b.nii"):
            message = self.fate_of(zipped({name: b"x"}), "slip")
            self.assertIn("leads out of the folder", message, name)
            self.assertNotIn("escaped", message)  # names may hold a person's
        link = zipfile.ZipInfo("volume.nii")
        link.create_system, link.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
        self.assertIn("link or a device", self.fate_of(zipped({link: b"/etc/passwd"}), "link"))
        bomb = zipped({f"{i}.dcm": bytes(30_000_000) for i in range(2)})
        self.assertLess(len(bomb), 1_000_000)
        self.assertIn("unpacks to more than", self.fate_of(bomb, "bomb"))
        many = zipped({f"{i}": b"" for i in range(20_001)}, zipfile.ZIP_STORED)
        self.assertIn("more than 20000 entries", self.fate_of(many, "many"))
        self.assertIn("there before", self.fate_of(zipped([("a", b"1"), ("a", b"2")]), "twice"))
        self.assertIn("archive", self.fate_of(zipped({"a.nii": b"1" * 999})[:-40], "torn"))
        self.assertFalse(pathlib.Path("/tmp/sanatrix-escaped.nii").exists())
        self.assertLess(self.server.memory_mb() - memory, 30)
        self.assertLess(self.server.health_ms(), 1000)

    def test_names_of_plans_are_text_and_stay_out_of_the_case(self):
        case = self.cases / "named"
        case.mkdir()
        (case / "case.json").write_text(json.dumps(
            {"format": "sanatrix-case", "version": 1, "pseudonym": "p", "label_preset": "sanatrix",
             "inputs": {}, "parameters": {}}))
        self.server.json("POST", "/api/cases/named/name", {"name": MARKUP})
        answer = self.server.ask("GET", "/api/cases/named")
        self.assertEqual(json.loads(answer.body)["plan_name"], MARKUP)
        self.assertEqual(answer.headers["Content-Type"], "application/json")
        self.assertEqual(answer.headers["X-Content-Type-Options"], "nosniff")
        self.assertEqual([p.name for p in case.iterdir()], ["case.json"])
        self.assertEqual(self.server.ask("POST", "/api/cases/named/name",
                                         json.dumps({"name": 200 * "x"})).status, 400)
        self.server.json("DELETE", "/api/cases/named", {})
        self.assertNotIn("onerror", (self.cases / ".planner/names.json").read_text())

    def test_errors_are_sentences_and_never_traces(self):
        answer = self.server.ask("GET", "/api/cases/nobody")
        told = json.loads(answer.body)
        self.assertEqual((answer.status, told["fault"]), (400, "input"))
        self.assertIn("no such case", told["what"])
        self.assertEqual(self.server.ask("POST", "/api/cases", "[1,2").status, 400)
        self.assertEqual(self.server.ask("PUT", "/api/cases", "{}").status, 405)

    def test_a_second_server_on_the_same_cases_is_refused(self):
        self.refused(4, "serve", "--cases", self.cases, "--port", "0", says=("another planner",))


class BeyondThisMachine(CliTest):
    """Another address only with TLS and a token."""

    def setUp(self):
        super().setUp()
        self.certificate, self.key = self.folder / "cert.pem", self.folder / "key.pem"
        made = subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
             "-nodes", "-subj", "/CN=planner.example", "-addext", "subjectAltName=IP:127.0.0.1",
             "-days", "2", "-keyout", self.key, "-out", self.certificate], capture_output=True)
        if made.returncode != 0:
            self.skipTest("openssl cannot make a certificate")
        self.token = self.folder / "token"
        self.token.write_text("0123456789abcdef0123456789ABCDEF\n")

    def test_it_refuses_to_start_without_them(self):
        cases = ("serve", "--cases", self.folder / "cases", "--port", "0", "--address", "0.0.0.0")
        self.refused(1, *cases, says=("--certificate, --key, --token",))
        secure = ("--certificate", self.certificate, "--key", self.key)
        self.refused(1, *cases, *secure, says=("missing: --token",))
        self.refused(1, *cases, "--certificate", self.certificate, "--token", self.token,
                     says=("missing: --key",))
        short = self.folder / "short"
        short.write_text("secret")
        self.refused(2, *cases, *secure, "--token", short, says=("32 letters",))
        self.refused(2, *cases, "--certificate", self.key, "--key", self.key, "--token", self.token,
                     says=("--certificate is not",))

    def test_with_them_it_speaks_tls_only_and_knows_its_own_name(self):
        process = subprocess.Popen(
            [binary(), "serve", "--cases", self.folder / "cases", "--port", "0", "--json",
             "--address", "0.0.0.0", "--host", "planner.example", "--certificate", self.certificate,
             "--key", self.key, "--token", self.token],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=ENVIRONMENT, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait, 60)
        self.addCleanup(process.send_signal, signal.SIGINT)
        address = json.loads(process.stdout.readline())["address"]
        self.assertTrue(address.startswith("https://planner.example:"), address)
        port = int(address.split(":")[2].split("/")[0])
        trust = ssl.create_default_context(cafile=self.certificate)

        def ask(path, host=f"planner.example:{port}", **headers):
            connection = http.client.HTTPSConnection("127.0.0.1", port, context=trust, timeout=30)
            connection.request("GET", path, headers={"Host": host, **headers})
            answer = connection.getresponse()
            answer.read()
            connection.close()
            return answer

        token = self.token.read_text().strip()
        self.assertEqual(ask(f"/start?key={token[:-1]}x").status, 401)
        entered = ask(f"/start?key={token}")
        self.assertEqual(entered.status, 303)
        self.assertIn("; Secure", entered.headers["Set-Cookie"])
        cookie = entered.headers["Set-Cookie"].split(";")[0]
        self.assertEqual(ask("/api/cases").status, 401)
        self.assertEqual(ask("/api/cases", Cookie=cookie).status, 200)
        self.assertEqual(ask("/api/cases", Cookie=cookie, host=f"evil.example:{port}").status, 421)
        plain = f"http://planner.example:{port}"
        self.assertEqual(ask("/api/cases", Cookie=cookie, Origin=plain).status, 403)
        with socket.create_connection(("127.0.0.1", port), timeout=15) as s:
            s.sendall(f"GET /api/cases HTTP/1.1\r\nHost: planner.example:{port}\r\n\r\n".encode())
            try:
                self.assertNotIn(b"HTTP/1.1 200", s.recv(4096))
            except ConnectionError:
                pass
        self.assertEqual(ask("/api/cases", Cookie=cookie).status, 200)  # still there


class Works(CliTest):
    """A small patient from upload to outcome, and the server killed on the way."""

    def setUp(self):
        super().setUp()
        self.cases = self.folder / "cases"
        self.labels, self.plan = write_patient(self.folder / "patient")
        self.server = Server(self.cases)

    def tearDown(self):
        if self.server.process.poll() is None:
            self.server.stop()

    def create(self):
        uploads = {}
        marked = json.loads(self.plan.read_text())
        marked["quadrant"] = marked["tumour"]["label"] = MARKUP
        packed = zipped({"scan of today/" + self.labels.name: self.labels.read_bytes(),
                         "__MACOSX/._x.nii.gz": b"clutter"})
        for name, file, content in (("labels", "labels.zip", packed),
                                    ("plan", "plan.json", json.dumps(marked).encode())):
            answer = self.server.ask("POST", f"/api/uploads?name={file}", content)
            uploads[name] = json.loads(answer.body)["upload"]
        made = self.server.json("POST", "/api/cases", {"name": "small", "set": QUICK_SET, **uploads})
        job = self.server.wait_for(made["job"])
        self.assertEqual(job["state"], "done", job)
        for upload in uploads.values():  # it may show and name a person
            self.assertFalse((self.cases / ".planner/uploads" / upload).exists(), "uploads stay")
        return made["case"]

    def test_a_photographed_scan_alone_becomes_a_case(self):
        scan = self.folder / "torso.obj"
        write_scan(scan)
        lines = scan.read_text().splitlines()
        textured = "\n".join(["mtllib material-1.mtl", "usemtl skin", "vt 0 0", "vt 1 0", "vt 0 1"] + [
            " ".join(["f", *(f"{v}/{k + 1}" for k, v in enumerate(line.split()[1:]))])
            if line.startswith("f ") else line for line in lines])
        picture = bytes.fromhex(  # 2 x 2 pixels of skin
            "89504e470d0a1a0a0000000d49484452000000020000000208020000" "00fdd49a73"
            "0000001049444154789c633830a101881820140033ce07419d96963a" "0000000049454e44ae426082")
        upload = self.server.upload([
            ("scan.obj", textured.encode()), ("picture-1.png", picture),
            ("material-1.mtl", b"newmtl skin\nKd 1 1 1\nmap_Kd picture-1.png\n")])
        made = self.server.json("POST", "/api/cases", {
            "name": "standing", "scan": upload, "density": "heterogeneous", "set": QUICK_SET})
        job = self.server.wait_for(made["job"])
        self.assertEqual(job["state"], "done", job)
        told = self.server.json("GET", f"/api/cases/{made['case']}")
        self.assertTrue(told["photograph"])
        self.assertEqual(told["parameters"]["segment.density"], "c")
        self.assertEqual(self.server.ask("GET", f"/api/cases/{made['case']}/scene").status, 200)

    def test_a_killed_server_loses_no_job_and_the_result_is_the_same(self):
        case = self.create()
        other = self.server.json("POST", f"/api/cases/{case}/copies", {"name": "undisturbed"})["case"]
        done = sanatrix("run", self.cases / other)
        self.assertEqual(done.returncode, 0, done.stderr)

        job = self.server.json("POST", f"/api/cases/{case}/run", {})["job"]
        self.server.wait_for(job, states=("running",))
        heal = self.cases / case / "run.jsonl"
        end = time.monotonic() + 120
        while '"stage":"heal"' not in heal.read_text() and time.monotonic() < end:
            time.sleep(0.02)
        self.server.stop(signal.SIGKILL)
        # The work's own process may be gone, too: a power cut.
        for pid in (int(p) for p in os.listdir("/proc") if p.isdigit()):
            try:
                words = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if str(self.cases / case).encode() in words:
                os.kill(pid, signal.SIGKILL)
        self.server = Server(self.cases)
        self.assertEqual(self.server.wait_for(job)["state"], "done")
        self.assertEqual(outcome_of(self.cases / case), outcome_of(self.cases / other))
        for page in (self.cases / case).rglob("*.html"):  # what a plan says never becomes markup
            self.assertNotIn("<img src=x", page.read_text(), page)

    def test_live_numbers_are_those_of_the_stage_and_follow_the_plan(self):
        case = self.create()
        plan = self.server.json("GET", f"/api/cases/{case}/plan")["plan"]

        def ask(changed, detail="full"):
            start = time.monotonic()
            answer = self.server.ask("POST", f"/api/cases/{case}/preview?detail={detail}",
                                     json.dumps(changed))
            milliseconds = 1e3 * (time.monotonic() - start)
            self.assertEqual(answer.status, 200, answer.body[:300])
            length = int.from_bytes(answer.body[4:8], "little")
            return json.loads(answer.body[8:8 + length]), milliseconds

        full, _ = ask(plan)
        job = self.server.json("POST", f"/api/cases/{case}/run", {"plan": plan, "to": "surgery"})
        self.assertEqual(self.server.wait_for(job["job"])["state"], "done")
        record = json.loads((self.cases / case / "stages/60-surgery/stage.json").read_text())
        self.assertAlmostEqual(full["excised_cm3"], record["numbers"]["excised_cm3"], places=6)
        live, milliseconds = ask(plan, "live")
        edits = [{**plan, "planned_margin_mm": 8 + 0.5 * i} for i in range(10)]
        before, times = self.server.cpu_ms(), []
        for edit in edits:
            times.append(ask(edit, "live")[1])
        cpu = (self.server.cpu_ms() - before) / len(edits)
        print(f"live numbers of a plan: {sorted(times)[5]:.0f} ms (median of 10), {cpu:.0f} ms of "
              f"CPU", flush=True)
        # 200 ms are promised on a busy machine, where a tenth of a core may be what one gets.
        self.assertLess(cpu, 45)  # 22 measured; 62 without kept distances
        # Live measures with half the resolution: within 1.5 % (documented: 1 % on finer meshes).
        self.assertAlmostEqual(live["excised_cm3"] / full["excised_cm3"], 1, delta=0.015)
        wider, _ = ask({**plan, "planned_margin_mm": 16.0})
        self.assertGreater(wider["excised_cm3"], 1.5 * full["excised_cm3"])
        # A square outline around the tumour against a cylinder: their areas are as 4 to pi.
        x, y, z = plan["tumour"]["centre_lps_mm"]
        square = [[x - 10, y - 30, z - 10], [x + 10, y - 30, z - 10],
                  [x + 10, y - 30, z + 10], [x - 10, y - 30, z + 10]]
        straight = {"axis_towards_skin_lps": [0, -1, 0]}
        outlined, _ = ask({**plan, "resection": {**straight, "outline_lps_mm": square}})
        round_one, _ = ask({**plan, "resection": {**straight, "radius_mm": 10}})
        self.assertAlmostEqual(outlined["excised_cm3"] / round_one["excised_cm3"], 4 / 3.1416,
                               delta=0.08)  # rounded edges take more from the square
        # A segment that follows the margin removes more than the cylinder, which it contains, and is
        # what the stage removes.
        wedge = {**plan, "resection": {**straight, "segment": {"apex_lps_mm": [x - 40, y - 30, z]}}}
        wedged, _ = ask(wedge)
        cylinder, _ = ask({**plan, "resection": straight})
        self.assertGreater(wedged["excised_cm3"], 1.05 * cylinder["excised_cm3"])
        job = self.server.json("POST", f"/api/cases/{case}/run", {"plan": wedge, "to": "surgery"})
        self.assertEqual(self.server.wait_for(job["job"])["state"], "done")
        record = json.loads((self.cases / case / "stages/60-surgery/stage.json").read_text())
        self.assertAlmostEqual(wedged["excised_cm3"], record["numbers"]["excised_cm3"], places=6)
        for kind in ("circumareolar", "radial", "inframammary"):
            line = self.server.json("POST", f"/api/cases/{case}/incisions/{kind}", plan)["line_mm"]
            self.assertGreaterEqual(len(line), 2)
        wrong = {**plan, "operated_side": "R"}
        answer = self.server.ask("POST", f"/api/cases/{case}/preview", json.dumps(wrong))
        self.assertEqual(answer.status, 400)
        self.assertIn("operated_side", json.loads(answer.body)["what"])

    def test_cancel_keeps_what_is_finished_and_resume_goes_on(self):
        case = self.create()
        job = self.server.json("POST", f"/api/cases/{case}/run", {})["job"]
        self.server.wait_for(job, states=("running",))
        self.server.json("POST", f"/api/jobs/{job}/cancel", {})
        self.assertEqual(self.server.wait_for(job)["state"], "cancelled")
        self.server.json("POST", f"/api/jobs/{job}/resume", {})
        self.assertEqual(self.server.wait_for(job)["state"], "done")
        self.assertEqual(self.server.ask("DELETE", f"/api/cases/{case}", "{}").status, 200)
        self.assertFalse((self.cases / case).exists())

    def test_a_failing_job_says_why_in_one_line(self):
        answer = self.server.ask("POST", "/api/uploads?name=x.nii.gz", b"this is no image")
        upload = json.loads(answer.body)["upload"]
        made = self.server.json("POST", "/api/cases", {"name": "bad", "labels": upload})
        job = self.server.wait_for(made["job"])
        self.assertEqual(job["state"], "failed")
        self.assertNotIn("\n", job["message"])
        self.assertGreater(len(job["message"]), 20)


class Describes(CliTest):
    def test_the_written_description_lists_exactly_the_routes(self):
        root = pathlib.Path(__file__).resolve().parents[2]
        described = json.loads((root / "docs/user/planner-api.json").read_text())
        listed = {f"{method.upper()} {path}" for path, methods in described["paths"].items()
                  for method in methods}
        source = (root / "apps/server/planner.cpp").read_text()
        import re
        routed = {" ".join(m) for m in re.findall(r'add\("([A-Z]+)", "([^"]+)"', source)}
        self.assertEqual(listed, routed)
        self.assertGreater(len(routed), 15)


if __name__ == "__main__":
    main()
