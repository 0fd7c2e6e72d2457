#!/usr/bin/env bash
# The way in on a Debian 12 machine: installs what is missing, builds what has changed, and runs.
#
#   ./ductile.sh [-n RANKS] COMMAND ...    the program; `run`, `pair`, `resume`, `compare`, `bench` on all cores
#   ./ductile.sh reproduce [--quick|--paper|--finer]  the paper's study, computed and laid beside the paper
#   ./ductile.sh converge [DIR]            the cases of doc/convergence.md on up to six lattices, and their figures
#   ./ductile.sh snakemake DIR [OPTION ...]  the cases of a campaign's directory, by Snakemake
#   ./ductile.sh test [CTEST OPTION ...]   builds everything and runs the tests
#   ./ductile.sh validate [CTEST ...]      the long validation runs
#   ./ductile.sh build                     builds everything, runs nothing
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$top/build

packages=(g++ cmake ninja-build pkg-config libpetsc-real-dev libopenmpi-dev openmpi-bin
  libeigen3-dev libhdf5-openmpi-dev libtomlplusplus-dev libcli11-dev libfmt-dev libxxhash-dev
  nlohmann-json3-dev libgtest-dev
  python3-numpy python3-scipy python3-pandas python3-h5py python3-matplotlib python3-jinja2)

say() { printf 'ductile.sh: %s\n' "$*" >&2; }

install_missing() {
  local missing=() package
  for package in "${packages[@]}"; do
    case $'\n'$installed in
      *$'\n'?"i $package"$'\n'*) ;;
      *) missing+=("$package") ;;
    esac
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  local sudo=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      say "these packages are missing, and only root can install them; as root, run"
      printf '  apt-get update && apt-get install -y --no-install-recommends %s\n' "${missing[*]}" >&2
      exit 1
    fi
    sudo=(sudo)
  fi
  say "installing with apt: ${missing[*]}"
  if ! { "${sudo[@]}" apt-get update -q && "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
         apt-get install -q -y --no-install-recommends "${missing[@]}"; } >&2; then
    say "that failed; to install them by hand, run"
    printf '  sudo apt-get update && sudo apt-get install -y --no-install-recommends %s\n' \
      "${missing[*]}" >&2
    exit 1
  fi
}

# Configures once, and lets ninja see whether a target is up to date.
make_target() {
  if [ ! -f "$build/build.ninja" ]; then
    say "configuring in build/"
    (cd "$top" && cmake --preset release) >"$top/.configure.log" 2>&1 ||
      { cat "$top/.configure.log" >&2; rm -f "$top/.configure.log"; exit 1; }
    rm -f "$top/.configure.log"
  fi
  case $(ninja -C "$build" -n "$1") in
    *"no work to do"*) return 0 ;;
  esac
  say "building (a few minutes the first time)"
  ninja -C "$build" "$1" >&2
}

# Open MPI refuses root and more ranks than cores unless told; one machine needs no kernel-assisted
# copies, which containers forbid.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none

ranks=$(nproc)
if [ "${1:-}" = -n ]; then
  ranks=${2:-}
  case $ranks in
    '' | *[!0-9]* | 0*) say "-n takes a number of ranks, at least 1, not '$ranks'"; exit 2 ;;
  esac
  shift 2
  case ${1:-} in
    run | pair | resume | compare | bench) ;;
    *) say "-n is of run, pair, resume, compare and bench, not of '${1:-}'; a campaign takes --ranks"; exit 2 ;;
  esac
fi

case ${1:-} in
  snakemake) packages+=(snakemake) ;;
  film | report | reproduce) packages+=(python3-vtk9 xvfb ffmpeg) ;;
esac
installed=$(dpkg-query -W -f '${db:Status-Abbrev}${Package}\n' "${packages[@]}" 2>/dev/null || true)$'\n'
install_missing

case ${1:-} in
  test | validate)
    make_target all
    label=(-LE validation)
    [ "$1" = test ] || label=(-L validation)
    shift
    exec ctest --test-dir "$build" --output-on-failure -j "$(nproc)" "${label[@]}" "$@"
    ;;
  build)
    make_target all
    ;;
  snakemake)
    make_target ductile
    campaign=${2:-}
    if [ ! -f "$campaign/campaign.json" ]; then
      say "'$campaign' has no campaign.json: lay it out with  ductile.sh campaign FILE -o DIR --prepare"
      exit 2
    fi
    shift 2
    DUCTILE=$build/drivers/ductile exec snakemake --snakefile "$top/drivers/campaign/Snakefile" \
      --directory "$campaign" --keep-going "$@"
    ;;
  reproduce)
    make_target ductile
    shift
    exec /usr/bin/python3 "$top/drivers/python/reproduce.py" --program "$build/drivers/ductile" "$@"
    ;;
  converge)
    case ${2:-} in -*) say "converge takes a directory for its results, not '$2'"; exit 2 ;; esac
    if [ $# -gt 2 ]; then say "converge takes one directory, not '$3' too"; exit 2; fi
    make_target ductile
    make_target convergence_cases
    results=${2:-runs/convergence}
    "$build/drivers/ductile" campaign "$top"/drivers/scenarios/convergence/*.toml -o "$results"
    say "drag, lift and deformation: some 45 minutes"
    "$build/tests/validation/convergence_cases" array wall shear lift >"$results/cases.csv.part"
    mv "$results/cases.csv.part" "$results/cases.csv"
    exec /usr/bin/python3 "$top/doc/figures/convergence.py" "$results"
    ;;
  run | pair | resume | compare | bench)
    make_target ductile
    if [ "$ranks" -eq 1 ]; then exec "$build/drivers/ductile" "$@"; fi
    [ ! -t 2 ] || export DUCTILE_LIVE=1
    # mpirun kills a second after it was asked to end; SIGUSR2 it hands on. In a session of its own it
    # does not hear what the terminal sends, and nothing has to read from there.
    setsid mpirun --quiet --bind-to none --oversubscribe -n "$ranks" "$build/drivers/ductile" "$@" \
      </dev/null &
    job=$!
    asked=USR2  # a second time it is to end at once
    [ "$1" != bench ] || asked=TERM
    trap 'waits=1; kill -$asked "$job"; asked=TERM' TERM INT HUP
    trap 'waits=1; kill -USR1 "$job"' USR1
    trap 'waits=1; kill -USR2 "$job"' USR2
    waits=1
    while [ $waits -eq 1 ]; do  # a signal interrupts the wait, not the job
      waits=0
      code=0
      wait "$job" || code=$?
    done
    exit "$code"
    ;;
  *)
    make_target ductile
    exec "$build/drivers/ductile" "$@"
    ;;
esac
