#!/bin/sh
# memory.sh BUILD: parsers, geometry and one estimate under valgrind; any error or lost block fails.
# The sanitizers' builds run all tests; this sees what they cannot: reads of values never set.
set -eu
cd "$(dirname "$0")/.."
build=$1
core=fixtures/core-hdr
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
check()
{
  echo "$1"
  valgrind --quiet --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite \
    "$@" >"$work/log" 2>&1 || { tail -n 40 "$work/log"; exit 1; }
}
for name in json_read pfm frame camera_file camera_json sphere_file surface lens light_json lights curves_csv \
  spline normal_equations nnls python_read samples_csv session session_json fit_file calibration_file \
  board_pose_file corners_vnl outputs position_json sight_file; do
  check "$build/tests/test_$name"
done
check "$build/halflight" estimate $core/frame.pfm --camera $core/camera.json \
  --sphere $core/sphere.json --threads 2 --json # --out draws, and the fonts' library keeps what it loads
check "$build/halflight" locate $core/frame.pfm --camera $core/camera.json --radius-m 0.02
