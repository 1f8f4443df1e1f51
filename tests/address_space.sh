#!/bin/sh
# address_space.sh COMMAND: where memory runs out, the command says so in one line and exits 1, or does
# what it was asked for; it never crashes. From the least address space in which it starts at all (found
# here: it depends on the libraries) some steps further, for `estimate` with a given and a found ball.
set -eu
cd "$(dirname "$0")/.."
command=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
OMP_NUM_THREADS=1 # each thread's stack takes address space
export OMP_NUM_THREADS
bad=0

# within KIBIBYTES WORD...: status to $status, its stderr to $work/err
within()
{
  size=$1
  shift
  status=0
  (ulimit -c 0 && ulimit -v "$size" && exec "$@" >"$work/out" 2>"$work/err" </dev/null) 2>/dev/null || status=$?
}

least=16384
while within $least "$command" info && [ $status != 0 ]; do
  least=$((least + least / 8))
  [ $least -lt 8388608 ] || { echo "does not start in 8 GiB"; exit 77; }
done
core=fixtures/core-hdr
ran=0 lacked=0
for more in 0 1 2 3 4 6 8 12 16 24 32 48 64 96; do
  for ball in "--sphere $core/sphere.json" '--radius-m 0.02'; do
    # shellcheck disable=SC2086 # two words
    within $((least + more * 1024)) "$command" estimate $core/frame.pfm --camera $core/camera.json \
      $ball --threads 1 --json
    case $status in
    0) ran=$((ran + 1)) ;;
    1)
      lacked=$((lacked + 1))
      if [ "$(wc -l <"$work/err")" != 1 ] || ! grep -q '^halflight: estimate: ' "$work/err"; then
        echo "with $more MiB more than it takes to start, $ball:"
        cat "$work/err"
        bad=1
      fi
      ;;
    *)
      echo "with $more MiB more than it takes to start, $ball: status $status"
      head -n 5 "$work/err"
      bad=1
      ;;
    esac
  done
done
echo "starts in $((least / 1024)) MiB; $lacked runs lacked memory, $ran had enough"
[ $ran -gt 0 ] || bad=1
exit $bad
