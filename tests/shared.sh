# shared.sh CC: the core as a shared library, configured with C alone: exports and installation.
set -eu
cc=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake -S . -B "$work/build" -DBUILD_SHARED_LIBS=ON -DBUILD_TESTING=OFF -DCMAKE_C_COMPILER="$cc" \
  -DHL_WITH_OPENCV=OFF -DHL_WITH_APRILTAG=OFF -DHL_WITH_LIBCAMERA=OFF > "$work/log" 2>&1 ||
  { cat "$work/log"; exit 1; }
cmake --build "$work/build" > "$work/log" 2>&1 || { tail -30 "$work/log"; exit 1; }
bash "$here/exports.sh" "$work/build/libhalflight.so"
bash "$here/install.sh" "$work/build" "$cc"
