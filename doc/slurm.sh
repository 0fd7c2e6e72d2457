#!/bin/bash
# A scenario in as many jobs as it takes:
#
#   sbatch slurm.sh SCENARIO DIRECTORY
#
# Each job ends itself before the queue's limit, with a checkpoint, and starts the next one, which goes
# on. Adapt the lines of #SBATCH, and `ductile`, the path of the program.
#SBATCH --job-name=ductile
#SBATCH --nodes=1
#SBATCH --ntasks=2
#SBATCH --time=04:00:00
#SBATCH --open-mode=append
#SBATCH --output=%x.log
scenario=$1
directory=$2
ductile=${DUCTILE:-ductile}
# A few minutes less than --time.
walltime=${DUCTILE_WALLTIME:-03:55:00}

steps() { grep -so '"steps": [0-9]*' "$directory/summary.json"; }
before=$(steps)

if [ -e "$directory/scenario.toml" ]; then
  mpirun "$ductile" resume "$directory" --max-walltime "$walltime"
else
  mpirun "$ductile" run "$scenario" -o "$directory" --force --max-walltime "$walltime"
fi
code=$?

# 5: a signal ended it, 6: its time was over; both go on, unless the time did not do for a single step.
# Anything else is the end, or needs somebody.
case $code in
  5 | 6) [ "$(steps)" = "$before" ] || sbatch "$0" "$scenario" "$directory" ;;
esac
exit "$code"
