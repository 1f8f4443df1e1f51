# install.sh BUILD CC: the installed library is found, built against and run, through CMake's package
# and through pkg-config; the examples of src/examples too.
set -eu
build=$1
cc=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/root" > "$work/log"
if grep -rl --include='*.cmake' --include='*.pc' -e "$build" "$work/root"; then
  echo "the files above name the build folder"
  exit 1
fi
test ! -e "$work/root/include/halflight/bridge_opencv.h"
test ! -e "$work/root/include/halflight/lens_names.h"

cat > "$work/camera.json" <<'JSON'
{"format":"halflight-camera","version":1,"model":"pinhole","width":640,"height":480,
 "fx":1400,"fy":1400,"cx":319.5,"cy":239.5,"distortion":[-0.1,0,0,0,0]}
JSON
wanted="640 1.000"
check() {
  local got
  got=$("$@" "$work/camera.json")
  echo "$1: $got"
  test "${got#* }" = "$wanted"
}

frames=$PWD/fixtures/core-hdr
# examples FOLDER: each does what it says, of two captures the second finds all there
examples() {
  "$1/estimate_memory" | tee "$work/said"
  grep -q ', trusted$' "$work/said"
  rm -rf "$work/session"
  test "$("$1/capture_source" "$work/session")" = "4 of 4 frames from invented, 4 of them now"
  test "$("$1/capture_source" "$work/session")" = "4 of 4 frames from invented, 0 of them now"
  "$1/relight_photo" "$frames/frame.pfm" "$frames/camera.json" "$frames/sphere.json" -1 0 -1 "$work/relit.pfm" \
    | tee "$work/said"
  awk '{ exit !($5 + 0 > 0 && $5 < 5) }' "$work/said" # per cent off the photo
  test -s "$work/relit.pfm"
}

cmake -S "$here/consumer" -B "$work/cmake" -DCMAKE_PREFIX_PATH="$work/root" \
  -DCMAKE_C_COMPILER="$cc" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cmake --build "$work/cmake" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
check "$work/cmake/consumer"
cmake -S "$here/../src/examples" -B "$work/examples" -DCMAKE_PREFIX_PATH="$work/root" \
  -DCMAKE_C_COMPILER="$cc" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cmake --build "$work/examples" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
examples "$work/examples"

pc=$(find "$work/root" -name halflight.pc)
export PKG_CONFIG_PATH="$(dirname "$pc")${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}"
static=--static
if find "$work/root" -name 'libhalflight.so' | grep -q .; then
  static=
  export LD_LIBRARY_PATH="$(dirname "$(dirname "$pc")")"
fi
# shellcheck disable=SC2046,SC2086
"$cc" -std=c11 -o "$work/consumer" "$here/consumer/main.c" \
  $(pkg-config $static --cflags --libs halflight) -lm
check "$work/consumer"
mkdir "$work/plain"
for name in estimate_memory capture_source relight_photo; do
  # shellcheck disable=SC2046,SC2086
  "$cc" -std=c11 -Wall -Wextra -Wshadow -Wconversion -Werror -o "$work/plain/$name" "$here/../src/examples/$name.c" \
    $(pkg-config $static --cflags --libs halflight) -lm
done
examples "$work/plain"

"$work/root/bin/halflight" info > /dev/null
