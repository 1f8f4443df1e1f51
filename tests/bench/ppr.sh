#!/bin/sh
# ppr.sh: time and memory of `estimate` on a ball of 100 px radius in 640 x 480, beside R's ppr on the
# same pixels of one channel, each the fastest of a few runs. Needs Rscript (Debian: r-base-core). It
# prints figures and asserts none: a busy machine is no fault of the code.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
project=$(cd "$here/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
LC_ALL=C
export LC_ALL

build() # NAME option...
{
  name=$1
  shift
  { cmake -S "$project" -B "$work/$name" -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF "$@" &&
    cmake --build "$work/$name" -j 2; } >"$work/log" 2>&1 || { tail -n 30 "$work/log"; exit 1; }
}
build all
build core -DHL_WITH_OPENCV=OFF -DHL_WITH_APRILTAG=OFF -DHL_WITH_LIBCAMERA=OFF
cmake --install "$work/core" --prefix "$work/root" >"$work/log"
pc=$(dirname "$(find "$work/root" -name halflight.pc)")
# shellcheck disable=SC2046
cc -std=c11 -O2 -o "$work/scene" "$here/scene.c" \
  $(PKG_CONFIG_PATH=$pc pkg-config --static --cflags --libs halflight) -lm
cc -std=c11 -D_XOPEN_SOURCE=700 -O2 -o "$work/peak" "$here/peak.c"
"$work/scene" "$work"

# run BUILD OPTION VALUE: `estimate` five times on one thread; milliseconds of the fastest run go to
# $estimate and $locate, the peak to $peak
run()
{
  command=$work/$1/halflight
  shift
  : >"$work/times"
  for _ in 1 2 3 4 5; do
    "$work/peak" "$command" estimate "$work/frame.pfm" --camera "$work/camera.json" "$@" \
      --threads 1 --json >"$work/light.json" 2>"$work/peak.txt" || true
    tr -d ' \n' <"$work/light.json" |
      sed 's/.*"timing_ms":{\([^}]*\)}.*/\1/; s/[":a-z]\{1,\}/ /g; s/,/ /g' >>"$work/times"
    echo >>"$work/times"
  done
  pixels=$(sed -n 's/.*"pixels": *\([0-9]*\).*/\1/p' "$work/light.json" | head -n 1)
  locate=$(awk 'NF { print $2 }' "$work/times" | sort -n | head -n 1)
  estimate=$(awk 'NF { print $3 }' "$work/times" | sort -n | head -n 1)
  peak=$(tail -n 1 "$work/peak.txt")
}
run all --sphere "$work/sphere.json"
estimate_known=$estimate
peak_all=$peak
run core --sphere "$work/sphere.json"
peak_core=$peak
run all --radius-m 0.02
ppr=$(for _ in 1 2 3; do Rscript "$here/ppr.R" "$work/pixels.csv"; done | sort -n | head -n 1)

awk -v pixels="$pixels" -v ppr="$ppr" -v known="$estimate_known" -v found="$estimate" \
  -v locate="$locate" -v core="$peak_core" -v all="$peak_all" 'BEGIN {
    printf "ppr, 1 channel of %d pixels     %10.1f ms\n", pixels, 1000 * ppr
    printf "estimate, 3 channels, 1 thread     %10.1f ms   1/%.1f of it\n", known, 1000 * ppr / known
    printf "locate, 640 x 480                  %10.1f ms   %.2f of the estimate\n", locate, locate / found
    printf "peak resident size, without OpenCV %10.1f MB\n", core
    printf "peak resident size, with OpenCV    %10.1f MB\n", all
  }'
