#!/usr/bin/python3
"""A run that is killed again and again, and goes on each time on another number of ranks, leaves
what a run leaves that nobody disturbs.

    kills.py PROGRAM MPIEXEC FAULTS SCENARIO WORK KILLS [SEED]

KILLS runs are killed: half of them at a random moment, half in the middle of a random write, which
FAULTS, to be preloaded, arranges. The rows and frames are then compared, byte by byte.
"""
import filecmp
import os
import random
import shutil
import signal
import subprocess
import sys
import time

program, mpiexec, faults, scenario, work, kills = sys.argv[1:7]
kills, work = int(kills), os.path.realpath(work)
rng = random.Random(int(sys.argv[7]) if len(sys.argv) > 7 else 1)
environment = {k: v for k, v in os.environ.items() if not k.startswith(("PMIX_", "OMPI_COMM"))}


def command(ranks, *arguments):
    launch = [mpiexec, "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks)]
    return (launch if ranks > 1 else []) + [program, *arguments]


def kill_all(pid):
    """The process and all that it has started."""
    children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True,
                              text=True, check=False).stdout.split()
    for child in children:
        kill_all(int(child))
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def start(ranks, arguments, fault=None):
    extra = {}
    if fault:
        extra = {"LD_PRELOAD": faults, "FAULT_PATH": work, "FAULT_KIND": "kill", "FAULT_AT": str(fault)}
    return subprocess.Popen(command(ranks, *arguments), env=environment | extra,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def files(directory):
    frames = os.path.join(directory, "frames")
    return ["trajectory.csv", "run.h5", "run.xdmf"] + sorted(
        os.path.join("frames", name) for name in os.listdir(frames))


def check_equal(a, b, story):
    names = files(a)
    if files(b) != names:
        sys.exit(f"{story}: {files(b)} instead of {names}")
    for name in names:
        if not filecmp.cmp(os.path.join(a, name), os.path.join(b, name), shallow=False):
            sys.exit(f"{story}: {name} differs from that of an undisturbed run")


shutil.rmtree(work, ignore_errors=True)
os.makedirs(work)
reference = os.path.join(work, "reference")
counter = work + ".operations"
if os.path.exists(counter):
    os.remove(counter)
begin = time.monotonic()
subprocess.run(command(1, "run", scenario, "-o", reference), check=True, stdout=subprocess.DEVNULL,
               stderr=subprocess.DEVNULL,
               env=environment | {"LD_PRELOAD": faults, "FAULT_COUNT": counter,
                                  "FAULT_PATH": work})
duration = time.monotonic() - begin
operations = int(open(counter, encoding="ascii").read())
print(f"undisturbed: {duration:.1f} s, {operations} operations on files, "
      f"{len(files(reference)) - 3} frames")

killed = runs = resumed = before = by_fault = 0
while killed < kills:
    runs += 1
    directory = os.path.join(work, "killed")
    shutil.rmtree(directory, ignore_errors=True)
    story = []
    deaths = rng.randint(1, 8)
    ranks = 0
    while True:
        ranks = ranks % 3 + 1
        started = os.path.exists(os.path.join(directory, "scenario.toml"))
        arguments = ["resume", directory] if started else [
            "run", scenario, "-o", directory, "--force"]
        dies = len(story) < deaths
        fault = rng.randint(1, operations // 2) if dies and rng.random() < 0.5 else None
        process = start(ranks, arguments, fault)
        if dies and fault is None:
            try:
                process.wait(rng.uniform(0.2, 0.9) * duration)
            except subprocess.TimeoutExpired:
                kill_all(process.pid)
        try:
            said = process.communicate(timeout=300)[0]
        except subprocess.TimeoutExpired:
            kill_all(process.pid)
            sys.exit(f"{story}: {arguments} on {ranks} ranks hangs")
        resumed += "goes on from t =" in said
        before += "checkpoint-before.h5" in said
        if process.returncode == 0:
            break
        if not dies:
            sys.exit(f"{story}: {arguments} on {ranks} ranks ends with {process.returncode}:\n{said}")
        # mpirun of a rank that was killed says so with 137, if it is not killed itself.
        if process.returncode not in ((-signal.SIGKILL,) if ranks == 1 else (-signal.SIGKILL, 137)):
            sys.exit(f"{story}: {arguments} on {ranks} ranks, to be killed, ends with "
                     f"{process.returncode}:\n{said}")
        by_fault += fault is not None
        story.append((ranks, f"operation {fault}" if fault else "any moment"))
        killed += 1
    check_equal(reference, directory, story)
if not (resumed and by_fault):
    sys.exit(f"of {killed} kills {by_fault} were within a write, and {resumed} runs went on from a "
             "checkpoint: neither is to be 0")
print(f"{runs} runs, killed {killed} times, {by_fault} of them within a write, gone on from a "
      f"checkpoint {resumed} times, from the one before the latest {before} times, are the "
      "undisturbed one, byte by byte")
