# install.sh BUILD CC: the installed library is found, built against and run, through CMake's package
# and through pkg-config.
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

cmake -S "$here/consumer" -B "$work/cmake" -DCMAKE_PREFIX_PATH="$work/root" \
  -DCMAKE_C_COMPILER="$cc" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cmake --build "$work/cmake" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
check "$work/cmake/consumer"

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

"$work/root/bin/halflight" info > /dev/null
