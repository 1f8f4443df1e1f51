#!/bin/sh
# fuzz.sh BUILD SECONDS [READER...]: every fuzzer of a build with HL_FUZZ=ON for so long, two at a time,
# from tests/fuzz/corpus and what fuzz_seeds and the recorded frames give. One line a reader: how many
# inputs, and how many places of the code they reached. A finding fails, with its input kept in BUILD.
set -eu
cd "$(dirname "$0")/.."
build=$(cd "$1" && pwd)
seconds=$2
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
mkdir "$work/seeds"
"$build/tests/fuzz/fuzz_seeds" "$work/seeds"
mkdir "$work/seeds/frame"
for frame in fixtures/core-hdr/frame.pfm fixtures/dome-a/01.png fixtures/phone-jpeg/frame.jpg; do
  head -c 4096 $frame >"$work/seeds/frame/$(basename $frame)"
done
cp tests/fuzz/corpus/pfm/* "$work/seeds/frame"
cp -r tests/fuzz/corpus/fit "$work/seeds" 2>/dev/null || true

# words that the readers look for: the members' names of all seeds
{
  grep -rhoE '"[A-Za-z_][A-Za-z_0-9-]*"' tests/fuzz/corpus "$work/seeds" --binary-files=text
  grep -rhoE '[a-z_]{3,}:' tests/fuzz/corpus/yaml tests/fuzz/corpus/camera | sed 's/.*/"&"/'
  grep -hoE 'X\("[a-z_]+"|\{"[a-z-]+"' src/cli/cmd_*.c | sed 's/.*"\(.*\)"/"--\1"/'
} | sort -u >"$work/words"
cp "$work/seeds/fit/seed" "$work/seeds/reflectance/fit"

cat >"$work/one" <<'END'
#!/bin/sh
# one BUILD SECONDS WORK READER
build=$1 seconds=$2 work=$3 reader=$4
mkdir -p "$work/found/$reader" "$work/seeds/$reader"
set -- "$work/found/$reader" "$work/seeds/$reader"
[ ! -d "tests/fuzz/corpus/$reader" ] || set -- "$@" "tests/fuzz/corpus/$reader"
nice "$build/tests/fuzz/fuzz_$reader" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -seed=1 \
  -dict="$work/words" -artifact_prefix="$build/fuzz-$reader-" "$@" >"$work/log.$reader" 2>&1
status=$?
[ "$status" = 0 ] || { tail -n 40 "$work/log.$reader"; echo "$reader: FOUND"; exit 1; }
grep -a 'DONE' "$work/log.$reader" | tail -n 1 | sed "s/^/$reader: /"
END
readers=${*:-$(sed -n 's/^  X(\([a-z_]*\)).*/\1/p' tests/fuzz/readers.h)}
export OMP_NUM_THREADS=1
for reader in $readers; do
  echo "$reader"
done | xargs -P 2 -I READER sh "$work/one" "$build" "$seconds" "$work" READER
echo "no finding"
