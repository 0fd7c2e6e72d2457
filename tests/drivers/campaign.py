#!/usr/bin/python3
"""A campaign whose cases end in all the ways there are, and that is killed and goes on.

    campaign.py PROGRAM SCENARIO WORK KILLS [SNAKEFILE]

With SNAKEFILE, Snakemake runs the same cases and must come to the same campaign.csv.
"""
import csv
import filecmp
import os
import random
import shutil
import signal
import subprocess
import sys
import time

program, scenario, work, kills = sys.argv[1:5]
program, scenario = os.path.realpath(program), os.path.realpath(scenario)
snakefile = os.path.realpath(sys.argv[5]) if len(sys.argv) > 5 else None
environment = {k: v for k, v in os.environ.items() if not k.startswith(("PMIX_", "OMPI_COMM"))}
signal.signal(signal.SIGINT, signal.default_int_handler)  # children hear of it in any case
shutil.rmtree(work, ignore_errors=True)
os.makedirs(work)
work = os.path.realpath(work)
seed = random.randrange(10**6)
print(f"seed {seed}")
random.seed(seed)

# The long one flows so slowly that its bodies stay where they are: contact would end it too.
CASES = [("slow", 5, 0.4), ("quick", 10, 0.3), ("fails", 9, 0.2), ("long", 0.01, 1000),
         ("refused", 4000, 1)]


def campaign_file(name, long_limit):
    """The cases above, of which the long one comes to an end or not."""
    rows = [[reynolds, limit if case != "long" else long_limit] for case, reynolds, limit in CASES]
    path = os.path.join(work, name)
    with open(path, "w", encoding="ascii") as file:
        file.write(f"""scenario = "{os.path.relpath(scenario, work)}"
[set]
run.checkpoint_every = 0.002
[[axis]]
keys = ["channel.reynolds", "run.time_limit"]
values = {rows}
names = {[case for case, _, _ in CASES]}
""".replace("'", '"'))
    return path


def start(*arguments):
    return subprocess.Popen([program, "campaign", *arguments], env=environment, text=True, cwd=work,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def run(*arguments):
    process = start(*arguments)
    said = process.communicate(timeout=600)[0]
    return process.returncode, said


def expect(condition, *story):
    if not condition:
        sys.exit("\n".join(str(part) for part in story))


def rows(directory):
    with open(os.path.join(directory, "campaign.csv"), encoding="ascii", newline="") as file:
        return {row["case"]: row for row in csv.DictReader(file)}


def states(directory):
    return {case: row["state"] for case, row in rows(directory).items()}


def expect_same(directory, *story):
    """The directory's results are those of the undisturbed campaign, byte by byte."""
    names = ["campaign.csv"]
    for case, _, _ in CASES:
        if case == "refused":
            continue
        run_directory = os.path.join("cases", case)
        names += [os.path.join(run_directory, n) for n in ("trajectory.csv", "run.h5", "run.xdmf")]
        frames = os.path.join(run_directory, "frames")
        listed = sorted(os.listdir(os.path.join(whole, frames)))
        expect(sorted(os.listdir(os.path.join(directory, frames))) == listed, *story, frames)
        names += [os.path.join(frames, name) for name in listed]
    for name in names:
        same = filecmp.cmp(os.path.join(whole, name), os.path.join(directory, name), False)
        expect(same, *story, f"{name} differs from that of the undisturbed campaign")


def kill_all(directory):
    """SIGKILL to everything that has to do with the directory."""
    for entry in os.listdir("/proc"):
        if not entry.isdigit() or int(entry) == os.getpid():
            continue
        try:
            with open(f"/proc/{entry}/cmdline", "rb") as file:
                if directory.encode() in file.read():
                    os.kill(int(entry), signal.SIGKILL)
        except (FileNotFoundError, ProcessLookupError):
            pass


# A case alone. The limit of time on the clock is to let it end beside another, on this machine and
# with this build of the program, and to end the one that has no end soon.
alone = os.path.join(work, "alone")
begun = time.monotonic()
subprocess.run([program, "run", scenario, "--set", "run.checkpoint_every=0.002", "--set",
                "channel.reynolds=5", "--set", "run.time_limit=0.4", "-o", alone], check=True,
               env=environment, capture_output=True)
walltime = max(10, 5 * (time.monotonic() - begun))

# What an end looks like from outside: one case fails, since a file of its own is in the way, one
# comes to the limit of time on the clock, one has a value out of bounds.
endless = campaign_file("endless.toml", 1000)
first = os.path.join(work, "first")
code, said = run(endless, "-o", first, "--prepare")
expect(code == 0 and states(first) == {c: "waiting" for c, _, _ in CASES[:-1]} | {"refused": "refused"},
       code, said)
in_the_way = os.path.join(first, "cases", "fails", "trajectory.csv")
os.makedirs(os.path.join(in_the_way, "x"))
code, said = run(first, "--max-walltime", f"{walltime:.0f}s")
expect(code == 1, code, said)
expect(states(first) == {"slow": "finished", "quick": "finished", "fails": "failed",
                         "long": "walltime", "refused": "refused"}, states(first), said)
failed, refused = rows(first)["fails"], rows(first)["refused"]
expect("trajectory.csv" in failed["reason"], failed)
expect(refused["reason"].startswith("endless.toml:") and "must be a number from 0 to 1000"
       in refused["reason"], refused)
# The others are what they are alone.
expect(filecmp.cmp(os.path.join(alone, "trajectory.csv"),
                   os.path.join(first, "cases", "slow", "trajectory.csv"), False), "slow")

# Undisturbed, with an end to the long one; and the campaign of above goes on to the same.
finite = campaign_file("finite.toml", 0.5)
whole = os.path.join(work, "whole")
begun = time.monotonic()
code, said = run(finite, "-o", whole)
span = time.monotonic() - begun
expect(code == 1 and set(states(whole).values()) == {"finished", "refused"}, code, said)
shutil.rmtree(in_the_way)
before = os.stat(os.path.join(first, "cases", "slow", "summary.json")).st_mtime_ns
changed = campaign_file("changed.toml", rows(first)["long"]["t[W^2/nu]"])  # it is there already
code, said = run(changed, "-o", first)
expect(code == 1 and set(states(first).values()) == {"finished", "refused"}, code, said)
expect(os.stat(os.path.join(first, "cases", "slow", "summary.json")).st_mtime_ns == before,
       "a case that had ended was run again")
for name in ("slow", "quick", "fails"):
    expect(rows(first)[name] == rows(whole)[name], rows(first)[name], rows(whole)[name])

# Another system in the place of one that has results.
other = campaign_file("other.toml", 0.5)
with open(other, encoding="ascii") as file:
    text = file.read()
with open(other, "w", encoding="ascii") as file:
    file.write(text.replace("[set]\n", "[set]\nfluid.tau = 0.9\n"))
code, said = run(other, "-o", first)
expect(code == 2 and "fluid.tau = 0.9 where the run has 1.0" in said and "--force" in said, code, said)

# Some cases of a campaign, and two campaigns in one queue: the same cases, the same rows.
some = os.path.join(work, "some")
code, said = run(finite, "-o", some, "--only", "q*", "--only", "finite/slow")
expect(code == 0 and "long" not in said, code, said)
expect(states(some) == {"slow": "finished", "quick": "finished", "fails": "waiting",
                        "long": "waiting", "refused": "refused"}, states(some), said)
for name in ("slow", "quick"):
    expect(rows(some)[name] == rows(whole)[name], rows(some)[name], rows(whole)[name])
code, said = run(some, "--only", "nothing*")
expect(code == 2 and '--only "nothing*": no case is called so: the first one is slow' in said,
       code, said)
# The longest case first, and alone, on two ranks; and one by one, as an engine calls for them.
wide = os.path.join(work, "wide")
code, said = run(finite, "-o", wide, "--only", "quick", "--only", "slow", "--ranks", "2",
                 "--at-once", "1")
expect(code == 0 and "2 cases to run, 1 at once on 2 ranks each" in said, code, said)
expect(said.index("slow: finished") < said.index("quick: finished"), said)
single = os.path.join(work, "single")
code, said = run(finite, "-o", single, "--prepare")
for name in ("quick", "slow"):
    code, said = run(single, "--case", name)
    expect(code == 0, code, said)
code, said = run(single, "--gather")
expect(code == 0, code, said)
for name in ("slow", "quick"):
    for directory in (wide, single):
        expect(rows(directory)[name] == rows(whole)[name], directory, rows(directory)[name])
short = campaign_file("short.toml", 0.2)
both = os.path.join(work, "both")
code, said = run(finite, short, "-o", both, "--only", "*/quick", "--only", "short/long")
expect(code == 0 and "finite/quick" in said and "short/long" in said, code, said)
expect(rows(os.path.join(both, "finite"))["quick"] == rows(whole)["quick"], said)
expect({name for name, row in rows(os.path.join(both, "short")).items()
        if row["state"] == "finished"} == {"quick", "long"}, said)
code, said = run(os.path.join(both, "finite"), os.path.join(both, "short"))
expect(code == 1 and {row["state"] for name in ("finite", "short")
                      for row in rows(os.path.join(both, name)).values()} ==
       {"finished", "refused"}, code, said)
expect(rows(os.path.join(both, "finite")) == rows(whole), said)
code, said = run(finite, finite, "-o", both)
expect(code == 2 and "both would have the directory" in said, code, said)
code, said = run(finite, whole)
expect(code == 2 and "either campaign files or directories" in said, code, said)

# Of cases that wait there is nothing to lose: they become what the file has made of them.
waiting = os.path.join(work, "waiting")
code, said = run(finite, "-o", waiting, "--prepare")
code, said = run(other, "-o", waiting, "--only", "quick")
expect(code == 0, code, said)
with open(os.path.join(waiting, "cases", "long", "scenario.toml"), encoding="ascii") as file:
    expect("tau = 0.9" in file.read(), "an old scenario is still laid out")
code, said = run(finite, "-o", waiting, "--only", "long")
expect(code == 2 and "cases/quick: fluid.tau = 1.0 where the run has 0.9" in said, code, said)

# Killed, all of it, at moments of no choice.
killed = os.path.join(work, "killed")
survived = 0
for n in range(int(kills)):
    process = start(finite, "-o", killed)
    time.sleep(random.uniform(0.1, 0.9) * span / int(kills))
    if process.poll() is not None:
        survived += 1
    kill_all(killed)
    process.wait()
    process.stdout.close()
expect(survived < int(kills), f"all of {kills} kills came too late, seed {seed}")
# SIGTERM is heard, and ends the runs with what they have.
stopped = os.path.join(work, "stopped")
process = start(endless, "-o", stopped, "--only", "long")
frame = os.path.join(stopped, "cases", "long", "frames", "000001.h5")
for _ in range(1200):
    if os.path.exists(frame):
        break
    time.sleep(0.05)
process.send_signal(signal.SIGTERM)
said = process.communicate(timeout=300)[0]
expect(process.returncode == 5 and "SIGTERM came" in said, process.returncode, said)
expect(states(stopped)["long"] == "unfinished", states(stopped), said)
expect(os.path.exists(os.path.join(stopped, "cases", "long", "checkpoint.h5")), said)
code, said = run(finite, "-o", killed)
expect(code == 1, code, said)
expect_same(killed, f"{kills} kills, seed {seed}")
print(f"{kills} kills, {survived} of them after the end")

if snakefile:
    by_snakemake = os.path.join(work, "snakemake")
    code, said = run(finite, "-o", by_snakemake, "--prepare")
    expect(code == 0, code, said)
    made = subprocess.run(["snakemake", "--snakefile", snakefile, "--directory", by_snakemake,
                           "--keep-going", "--jobs", "2"], env=environment | {"DUCTILE": program},
                          capture_output=True, text=True, check=False)
    expect(made.returncode == 0, made.stdout, made.stderr)
    expect_same(by_snakemake, "by Snakemake")
    print("the same by Snakemake")
