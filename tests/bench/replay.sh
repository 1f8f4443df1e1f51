#!/bin/sh
# Speed and memory of a replay: replay.sh HALFLIGHT [FRAMES [LONG]]
# A drawn session (replay_session.py) of FRAMES (240) frames, 640 x 480, 16-bit PNG, a ball of 100 px radius:
# frames a second on 1 and 2 jobs with `locate` once, and their ratio; then resident memory on 50 frames and on
# LONG (5000), the frames repeated. Nothing else should run meanwhile. user+sys / frame is what load disturbs least.
set -eu
HALFLIGHT=$1
FRAMES=${2:-240}
LONG=${3:-5000}
HERE=$(cd "$(dirname "$0")" && pwd)
PYTHON=${PYTHON:-/usr/bin/python3}
WORK=$(mktemp -d)
trap 'rm -rf "$WORK"' EXIT

# NAME FRAMES JOBS: one line, and "$WORK/wall" with the seconds
run() {
  rm -rf "$WORK/out"
  "$PYTHON" - "$HALFLIGHT" "$WORK/$1" "$3" "$WORK/out" "$2" "$WORK/wall" <<'P'
import resource
import subprocess
import sys
import time

command, session, jobs, out, frames, wall = sys.argv[1:]
start = time.time()
subprocess.run([command, "replay", session, "--jobs", jobs, "--out", out], stdout=subprocess.DEVNULL,
               stderr=subprocess.DEVNULL, check=False)
took, used = time.time() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
cpu = used.ru_utime + used.ru_stime
print(f"{frames:>6} frames, {jobs} jobs: {took:8.2f} s  {int(frames) / took:7.1f} frames/s  "
      f"{1e3 * cpu / int(frames):6.1f} ms of CPU a frame  {used.ru_maxrss / 1024:7.1f} MB at most")
with open(wall, "w", encoding="utf-8") as f:
    f.write(f"{took}\n")
P
}

"$PYTHON" "$HERE/replay_session.py" "$WORK/speed" "$FRAMES"
run speed "$FRAMES" 1
one=$(cat "$WORK/wall")
run speed "$FRAMES" 2
awk -v a="$one" -v b="$(cat "$WORK/wall")" \
  'BEGIN { printf "1 to 2 jobs: %.2f times as fast, efficiency %.0f %%\n", a / b, 50 * a / b }'
rm -rf "$WORK/speed" "$WORK/out"
for n in 50 "$LONG"; do
  "$PYTHON" "$HERE/replay_session.py" "$WORK/long" "$n"
  run long "$n" 2
  rm -rf "$WORK/long"
done
