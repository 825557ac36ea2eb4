"""sanatrix sweep on a real Slurm of two nodes on the loopback device, one of which is killed."""
import csv
import getpass
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time
import unittest

import sanatrix_cli
from sanatrix_cli import CliTest, QUICK, binary, main, write_patient

TOOLS = ["slurmctld", "slurmd", "sbatch", "munged"]


def tool(name):
    return shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/usr/local/sbin")


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


CONFIG = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmctldPort={ports[0]}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/ctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/ctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdTimeout=10
ReturnToService=2
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 State=UNKNOWN
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 State=UNKNOWN
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


@unittest.skipUnless(all(map(tool, TOOLS)), "Slurm is not installed (apt install slurm-wlm munge)")
@unittest.skipUnless(os.geteuid() == 0, "a private Slurm cluster needs root")
class ASlurmCluster(CliTest):
    def setUp(self):
        super().setUp()
        self.running = {}
        self.addCleanup(self.stop_cluster)
        self.cluster = self.folder / "cluster"
        for name in ["", "state", "spool-n1", "spool-n2"]:
            (self.cluster / name).mkdir()
        os.chmod(self.folder, 0o755)
        os.chmod(self.cluster, 0o755)
        host = socket.gethostname().split(".")[0]
        (self.cluster / "slurm.conf").write_text(CONFIG.format(
            folder=self.cluster, host=host, user=getpass.getuser(), ports=free_ports(3)))
        os.environ["SLURM_CONF"] = sanatrix_cli.ENVIRONMENT["SLURM_CONF"] = str(
            self.cluster / "slurm.conf")
        key = self.cluster / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.daemon("munged", "--foreground", "--force", f"--key-file={key}",
                    f"--socket={self.cluster}/munge.socket",
                    f"--pid-file={self.cluster}/munge.pid", f"--log-file={self.cluster}/munge.log",
                    f"--seed-file={self.cluster}/munge.seed")
        self.until(lambda: (self.cluster / "munge.socket").exists(), 20, "munged")
        self.daemon("slurmctld", "-D")
        for node in ["n1", "n2"]:
            self.daemon("slurmd", "-D", "-N", node, name=node)
        self.until(lambda: self.idle_nodes() == 2, 60, "two idle nodes")

    def daemon(self, program, *words, name=None):
        log = open(self.cluster / f"{name or program}.out", "wb")
        self.addCleanup(log.close)
        self.running[name or program] = subprocess.Popen(
            [tool(program), *words], stdout=log, stderr=log, stdin=subprocess.DEVNULL)

    def stop_cluster(self):
        for process in self.running.values():
            process.kill()
            process.wait()

    def until(self, ready, seconds, what):
        end = time.time() + seconds
        while not ready():
            if time.time() > end:
                logs = "\n".join(p.read_text(errors="replace")[-1500:]
                                 for p in self.cluster.glob("*.log"))
                self.fail(f"waited in vain for {what}\n{logs}")
            time.sleep(0.2)

    def idle_nodes(self):
        done = subprocess.run(["sinfo", "-h", "-N", "-o", "%t"], capture_output=True, text=True)
        return sum(state.startswith("idle") for state in done.stdout.split())

    def steps_on(self, node):
        """Processes of the jobs that run on a node: slurmstepd and all below it."""
        done = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True)
        rows = [line.split(None, 2) for line in done.stdout.splitlines()[1:]]
        jobs = subprocess.run(["squeue", "-h", "-t", "R", "-w", node, "-o", "%A"],
                              capture_output=True, text=True).stdout.split()
        found = [int(pid) for pid, _, args in rows
                 if args.startswith("slurmstepd: ") and any(f"[{j}." in args for j in jobs)]
        for pid, parent, _ in rows:
            if int(parent) in found:
                found.append(int(pid))
        return found

    def test_every_task_is_done_once_though_a_node_dies(self):
        labels, plan = write_patient(self.folder / "patient")
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", labels, "--plan", plan)
        self.run_ok("run", case, "--to", "supine", *QUICK)
        sweep = self.folder / "sweep.json"
        sweep.write_text(json.dumps({"case": "case", "parameters": {
            "surgery.margin_mm": [7, 8, 9], "heal.days": [30, 60]}}))
        driver = subprocess.Popen(
            [binary(), "sweep", sweep, "--engine", "slurm", "--out", self.folder / "out", "-q"],
            env=sanatrix_cli.ENVIRONMENT, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.until(lambda: self.steps_on("n1"), 120, "a job on n1")
        self.running.pop("n1").kill()
        for pid in self.steps_on("n1"):
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        _, stderr = driver.communicate(timeout=900)
        self.assertEqual(driver.returncode, 0, stderr)
        with open(self.folder / "out/results.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([r["status"] for r in rows], ["ok"] * 6)
        self.assertEqual({p.stem for p in (self.folder / "out/results").iterdir()},
                         {r["task"] for r in rows})
        # The cluster's numbers are those of this machine.
        self.run_ok("sweep", sweep, "--out", self.folder / "local", "-q")
        self.assertEqual((self.folder / "local/results.csv").read_bytes(),
                         (self.folder / "out/results.csv").read_bytes())


class WithoutSlurm(CliTest):
    def test_the_missing_scheduler_is_named(self):
        if shutil.which("sbatch"):
            self.skipTest("Slurm is here")
        labels, plan = write_patient(self.folder / "patient")
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", labels, "--plan", plan)
        self.run_ok("run", case, "--to", "supine", *QUICK)
        sweep = self.folder / "sweep.json"
        sweep.write_text(json.dumps({"case": "case"}))
        self.refused(2, "sweep", sweep, "--engine", "slurm", says=["sbatch", "--engine local"])


if __name__ == "__main__":
    main()
