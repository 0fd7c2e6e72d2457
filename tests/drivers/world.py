#!/usr/bin/python3
"""A run in a world where disks are full, signals come, and others want the same directory.

    world.py PROGRAM MPIEXEC FAULTS SCENARIO WORK [N]

FAULTS is preloaded to make operations on files fail: every N-th in turn, or a handful of them.
"""
import atexit
import filecmp
import json
import os
import shutil
import signal
import subprocess
import sys
import time

program, mpiexec, faults, scenario, work = sys.argv[1:6]
environment = {k: v for k, v in os.environ.items() if not k.startswith(("PMIX_", "OMPI_COMM"))}
signal.signal(signal.SIGINT, signal.default_int_handler)  # children hear of it in any case
shutil.rmtree(work, ignore_errors=True)
os.makedirs(work)
work = os.path.realpath(work)


def command(ranks, *arguments):
    launch = [mpiexec, "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks)]
    return (launch if ranks > 1 else []) + [program, *arguments]


def start(ranks, *arguments, **extra):
    process = subprocess.Popen(command(ranks, *arguments), env=environment | extra, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    atexit.register(lambda: process.poll() is None and process.kill())
    return process


def run(ranks, *arguments, **extra):
    """Exit code and all that was said. No run here takes five minutes, on a busy machine either."""
    process = start(ranks, *arguments, **extra)
    try:
        said = process.communicate(timeout=300)[0]
    except subprocess.TimeoutExpired:
        process.kill()
        sys.exit(f"{arguments} on {ranks} ranks hangs")
    return process.returncode, said


def expect(condition, *story):
    if not condition:
        sys.exit("\n".join(str(part) for part in story))


def names(directory):
    frames = sorted(os.listdir(os.path.join(directory, "frames")))
    return ["trajectory.csv", "run.h5", "run.xdmf"] + [os.path.join("frames", f) for f in frames]


def expect_same(directory, *story):
    expect(names(directory) == names(reference), *story, names(directory))
    for name in names(reference):
        same = filecmp.cmp(os.path.join(reference, name), os.path.join(directory, name), False)
        expect(same, *story, f"{name} differs from that of an undisturbed run")


def summary(directory):
    with open(os.path.join(directory, "summary.json"), encoding="utf-8") as file:
        return json.load(file)


def fresh(name):
    directory = os.path.join(work, name)
    shutil.rmtree(directory, ignore_errors=True)
    return directory


def wait_for(path):
    for _ in range(600):
        if os.path.exists(path):
            return
        time.sleep(0.05)
    sys.exit(f"{path} does not come")


short = ["--set", "run.time_limit=0.25"]
reference = os.path.join(work, "reference")
counter = work + ".operations"
if os.path.exists(counter):
    os.remove(counter)
code, text = run(1, "run", scenario, *short, "-o", reference, LD_PRELOAD=faults,
                 FAULT_PATH=work, FAULT_COUNT=counter)
expect(code == 0, text)
with open(counter, encoding="ascii") as file:
    operations = int(file.read())

# A disk that is full, from some write on or at one alone: the run ends with a word, and goes on when
# there is room.
step = int(sys.argv[6]) if len(sys.argv) > 6 else max(1, operations // 5)
tried = ended = 0
for ranks in (1, 2):
    for at in range(1, operations + 1, step):
        for kind in ("full", "once") if at % 2 else ("full",):
            directory = fresh("disk")
            code, text = run(ranks, "run", scenario, *short, "-o", directory, LD_PRELOAD=faults,
                             FAULT_PATH=directory, FAULT_KIND=kind, FAULT_AT=str(at))
            story = (f"{kind} at operation {at} of {operations}, {ranks} ranks: code {code}", text)
            tried += 1
            if code != 0:
                ended += 1
                expect(code == 1 and "cannot" in text, *story)
                expect("closing library" not in text and "Segmentation" not in text, *story)
            begun = os.path.exists(os.path.join(directory, "scenario.toml"))
            code, text = run(3 - ranks, *(["resume", directory] if begun else
                                          ["run", scenario, *short, "--force", "-o", directory]))
            expect(code == 0, *story, "and then", text)
            expect_same(directory, *story)
# The number of operations follows the clock, so that the last of them need not come.
expect(ended >= tried // 3, f"{ended} of {tried} full disks were noticed")
print(f"{tried} full disks at {operations} operations, {ended} of them noticed")

# A run that would take an hour. It flows so slowly that its bodies never meet: contact would end it
# too.
endless = ["--set", "run.time_limit=1000", "--set", "channel.reynolds=0.01"]

# Signals. The endless run ends within seconds, with its code, summary and picture. mpirun is to wait
# five seconds for a slow disk, in place of one.
for ranks, sent, expected in ((1, signal.SIGTERM, 5), (1, signal.SIGINT, 5), (1, signal.SIGUSR2, 5),
                              (2, signal.SIGUSR2, 5), (2, signal.SIGTERM, None)):
    directory = fresh("signal")
    process = start(ranks, "run", scenario, *endless, "--set", "run.checkpoint_every=0", "-o",
                    directory, OMPI_MCA_odls_base_sigkill_timeout="5")
    wait_for(os.path.join(directory, "frames", "000001.h5"))
    # A checkpoint on demand, and the run goes on.
    process.send_signal(signal.SIGUSR1)
    wait_for(os.path.join(directory, "checkpoint.h5"))
    frames = len(os.listdir(os.path.join(directory, "frames")))
    wait_for(os.path.join(directory, "frames", f"{frames + 1:06}.h5"))
    begin = time.monotonic()
    process.send_signal(sent)
    text = process.communicate(timeout=120)[0]
    took = time.monotonic() - begin
    story = (f"signal {sent} to {ranks} ranks: code {process.returncode} after {took:.1f} s", text)
    # mpirun has its own code where the signal was its own.
    expect(process.returncode == expected or expected is None and process.returncode != 0, *story)
    expect(took < 60, *story)
    expect(summary(directory)["status"] == "interrupted", *story)
    wait_for(os.path.join(directory, "trajectory.png"))
    code, text = run(1, "resume", directory, "--max-walltime", "5s")
    expect(code == 6 and "its time is used up" in text, f"code {code}", text)
    expect(summary(directory)["status"] == "walltime" and len(summary(directory)["legs"]) == 2,
           text)
print("signals end runs")

# One run at a time in a directory; a dead one's lock holds nobody up.
directory = fresh("shared")
process = start(1, "run", scenario, *endless, "-o", directory)
wait_for(os.path.join(directory, "frames", "000000.h5"))
for arguments in (["run", scenario, "-o", directory, "--force"], ["resume", directory]):
    code, text = run(1, *arguments)
    expect(code == 2 and f"another run is writing there (process {process.pid} on " in text, code,
           text)
process.kill()
process.wait()
code, text = run(1, "resume", directory, "--until", "0.1")
expect(code == 0, code, text)
print("a directory is one run's")

# Streams that take nothing.
with open("/dev/full", "w", encoding="ascii") as full:
    directory = fresh("full")
    process = subprocess.run(command(1, "run", scenario, *short, "-o", directory), stdout=full,
                             stderr=subprocess.PIPE, text=True, env=environment, check=False)
    expect(process.returncode == 1 and "said on stdout could be written" in process.stderr,
           process.returncode, process.stderr)
    expect_same(directory, "stdout full")
    process = subprocess.run(command(1, "resume", directory), stderr=full, env=environment,
                             stdout=subprocess.DEVNULL, check=False)
    expect(process.returncode == 0, process.returncode)
closed = " ".join(command(1, "run", scenario, *short, "-o", fresh("closed")))
for streams, expected in ((">&-", 1), ("2>&-", 0), ("<&-", 0)):
    shutil.rmtree(fresh("closed"), ignore_errors=True)
    code = subprocess.run(closed + " " + streams, shell=True, env=environment, check=False,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
    expect(code == expected, streams, code)
    expect_same(os.path.join(work, "closed"), streams)
print("streams that take nothing harm no results")

# A directory that goes away, or may not be written.
directory = fresh("gone")
process = start(1, "run", scenario, *endless, "-o", directory)
wait_for(os.path.join(directory, "frames", "000001.h5"))
os.rename(directory, directory + "-moved")
text = process.communicate(timeout=30)[0]
expect(process.returncode == 1 and "cannot write" in text, process.returncode, text)
code, text = run(1, "resume", directory + "-moved", "--until", "0.4")
expect(code == 0, code, text)
if os.geteuid() != 0:
    os.mkdir(fresh("mine"), 0o500)
    code, text = run(1, "run", scenario, "-o", os.path.join(work, "mine", "run"))
    expect(code == 1 and "Permission denied" in text, code, text)
code, text = run(1, "run", scenario, *short, "-o", fresh("home"), HOME="/proc", XDG_CACHE_HOME="")
expect(code == 0, code, text)
print("directories that go away end a run with a word")

# More memory than there is.
code, text = run(1, "run", scenario, "--set", "channel.nodes=2000", "-o", fresh("large"))
expect(code == 2 and "GB of memory" in text and not os.path.exists(os.path.join(work, "large")),
       code, text)

# A rank that stops: the others do not wait for ever.
directory = fresh("stopped")
process = start(2, "run", scenario, *endless, "--set", "run.patience=0.02", "-o", directory)
wait_for(os.path.join(directory, "frames", "000001.h5"))
children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True,
                          text=True, check=True).stdout.split()
os.kill(int(children[-1]), signal.SIGSTOP)
text = process.communicate(timeout=60)[0]
expect(process.returncode == 1 and "has waited for another one since step" in text,
       process.returncode, text)
print("a rank that stops ends the run")
