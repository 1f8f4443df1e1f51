#!/bin/bash
# fit_ppr.sh [LARGEST]: `fit --model pursuit --terms 2` beside R's ppr on the same samples of one channel, one
# thread, each the fastest of a few runs, from 10^3 to LARGEST (10^6) samples; then the error of two terms
# on 25 measured materials where their tables lie beside the project (fit_ppr.py). Needs Rscript (Debian:
# r-base-core). HALFLIGHT names the command, else it is built. It prints figures and asserts none: a busy
# machine is no fault of the code.
set -eu -o pipefail
here=$(cd "$(dirname "$0")" && pwd)
project=$(cd "$here/../.." && pwd)
largest=${1:-1000000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
export LC_ALL=C OMP_NUM_THREADS=1

if [ -z "${HALFLIGHT:-}" ]; then
  { cmake -S "$project" -B "$work/build" -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF &&
    cmake --build "$work/build" -j 2; } >"$work/log" 2>&1 || { tail -n 30 "$work/log"; exit 1; }
  HALFLIGHT=$work/build/halflight
fi
export HALFLIGHT

# samples N FILE: a rough gloss about h over n.v and a body about s under (1,1,1), 1 % noise
samples()
{
  awk -v n="$1" 'BEGIN {
    srand(1); print "nx,ny,nz,value"; s = 1 / sqrt(3); l = sqrt(2 + 2 * s)
    for (i = 0; made < n; i++) {
      z = 1 - 0.95 * ((i * 0.6180339887498949) % 1); r = sqrt(1 - z * z); t = 6.283185307179586 * ((i * 0.7548776662466927) % 1)
      x = r * cos(t); y = r * sin(t); ns = s * (x + y + z); if (ns < 0.02) continue
      nh = (s * (x + y) + (s + 1) * z) / l; q = nh * nh * (0.01 - 1) + 1
      v = ns + 0.004 * (0.01 / (q * q)) / z
      v *= 1 + 0.01 * (rand() + rand() + rand() + rand() - 2) * 1.732
      printf "%.9g,%.9g,%.9g,%.9g\n", x, y, z, (v > 0 ? v : 0); made++
    } }' >"$2"
}

# ours MAX FILE: milliseconds of the fastest of five, and the error
ours()
{
  for _ in 1 2 3 4 5; do
    "$HALFLIGHT" fit "$2" --model pursuit --terms 2 --max-terms "$1" --threads 1 --json |
      awk '/"estimate"/ { gsub(/[^0-9.e+-]/, " ", $0); t = $NF } /^ "relative_error"/ { gsub(/[",:a-z_]/, " "); e = $1 }
           END { print t, e }'
  done | sort -n | head -n 1
}

# theirs MAX FILE: the same of R, of three
theirs()
{
  for _ in 1 2 3; do Rscript "$here/fit_ppr.R" 2 "$1" "$2" | awk '{ print 1000 * $4, $3 }'; done | sort -n | head -n 1
}

printf '%9s  %34s  %34s\n' '' 'ppr(nterms = 2, max.terms = 2)' 'ppr(nterms = 2, max.terms = 5)'
printf '%9s  %9s %9s %7s %6s  %9s %9s %7s %6s\n' samples 'R, ms' 'ours' 'ratio' 'error' 'R, ms' 'ours' 'ratio' 'error'
for n in 1000 10000 100000 1000000; do
  [ "$n" -le "$largest" ] || break
  samples "$n" "$work/s.csv"
  printf '%9d' "$n"
  for max in 2 5; do
    read -r mine my_error < <(ours "$max" "$work/s.csv")
    read -r other its_error < <(theirs "$max" "$work/s.csv")
    awk -v a="$other" -v b="$mine" -v e="$my_error" -v f="$its_error" \
      'BEGIN { printf "  %9.1f %9.1f %7.1f %6.2f", a, b, a / b, e / f }'
  done
  echo
done
if /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
  /usr/bin/python3 "$here/fit_ppr.py" "$project/../shared/data/merl/npf.npz"
else
  echo "no python3-numpy: the materials' table is left out"
fi
