# includes.sh: who may include whom. src/ and calib/ meet only through include/halflight/, the command
# sees only the public headers and its own, and only the bridges see OpenCV and libcamera.
set -eu
status=0
forbid() { # what, pattern, files...
  local what=$1 pattern=$2
  shift 2
  if grep -nE "$pattern" "$@"; then
    echo "^ $what"
    status=1
  fi
}
bridges=$(find calib -name 'bridge_*.cpp')
others=$(find src calib include -name '*.[ch]' -o -name '*.cpp' | grep -vxF "$bridges" || true)
test -n "$others"
# shellcheck disable=SC2086
forbid "only bridge_*.cpp may include this" '^ *#include *[<"](opencv|opencv2|libcamera)' $others
forbid "calib/ may not include src/" '^ *#include *"([^"]*/)?src/' calib/*
forbid "src/ may not include calib/" '^ *#include *"([^"]*/)?calib/' $(find src -type f)
forbid "no way up a folder" '^ *#include *"\.\./' $(find src calib include -type f)
for header in calib/*.h; do
  forbid "private to calib/" "^ *#include *\"$(basename "$header")\"" $(find src include -type f)
done
for header in src/*.h; do
  forbid "private to src/" "^ *#include *\"$(basename "$header")\"" $(find calib include src/cli -type f)
done
exit $status
