#!/bin/sh
# One case of the command: run.sh HALFLIGHT MAKE_BALL CASE_FOLDER
#
# A case is a folder with
#   cmd      shell text; `halflight` is the command under test; runs among make_ball's default files
#   setup    shell text run before it (optional); `make_ball`, `make_corners` and `make_table` are there
#   stdout   expected lines (none without the file); stderr likewise. A line that starts with
#            `glob:` is a shell pattern, `...` alone stands for any lines that follow
#   exit     expected exit status (0 without the file)
#   files    names of the files that must be new afterwards, sorted (none without the file)
#   check    shell text that must succeed afterwards (optional)
# Nothing else may appear or change. A case that fails without `files` is run once more beside old
# outputs, which must stay as they are, byte for byte.
set -u
HALFLIGHT=$1
MAKE_BALL=$2
CASE=$3
WORK=$(mktemp -d) || exit 1
trap 'rm -rf "$WORK"' EXIT
trap 'exit 1' INT TERM
LC_ALL=C
LSAN_OPTIONS=suppressions=$(dirname "$0")/lsan.supp:print_suppressions=0
export LC_ALL LSAN_OPTIONS
bad=0

halflight() { "$HALFLIGHT" "$@"; }
make_ball() { "$MAKE_BALL" "$@"; }
make_corners() { "$(dirname "$MAKE_BALL")/make_corners" "$@"; }
make_table() { "$(dirname "$MAKE_BALL")/make_table" "$@"; }

complain()
{
  echo "$*"
  bad=1
}

# Every file with its check sum and size, every folder.
listing()
{
  (cd "$WORK/in" && find . -type f -exec cksum {} + | sort -k 3 && find . -type d | sort)
}

# matches FILE EXPECTED: line by line
matches()
{
  exec 3<"$1" 4<"$2"
  while IFS= read -r want <&4; do
    if [ "$want" = "..." ]; then
      exec 3<&- 4<&-
      return 0
    fi
    IFS= read -r got <&3 || { echo "missing line: $want"; return 1; }
    case $want in
    glob:*)
      pattern=${want#glob:}
      # shellcheck disable=SC2254 # the pattern is meant
      case $got in
      $pattern) ;;
      *) echo "line '$got' is not like '$pattern'"; return 1 ;;
      esac ;;
    *)
      [ "$got" = "$want" ] || { echo "line '$got' is not '$want'"; return 1; } ;;
    esac
  done
  if IFS= read -r got <&3; then
    echo "line too many: $got"
    return 1
  fi
  exec 3<&- 4<&-
}

# Run cmd and compare what it says.
speak()
{
  status=0
  (cd "$WORK/in" && . "$CASE/cmd") >"$WORK/stdout" 2>"$WORK/stderr" || status=$?
  due=0
  [ -f "$CASE/exit" ] && due=$(cat "$CASE/exit")
  [ "$status" = "$due" ] || complain "exit status $status, expected $due"
  for stream in stdout stderr; do
    expected=$CASE/$stream
    [ -f "$expected" ] || expected=/dev/null
    matches "$WORK/$stream" "$expected" || complain "$stream differs"
  done
  # one line a failure, for programs that read it
  if [ "$due" != 0 ] && [ "$(wc -l <"$WORK/stderr")" -ne 1 ]; then
    complain "stderr has not one line"
  fi
}

old_outputs()
{
  mkdir -p "$WORK/in/out"
  for name in out/light.json out/curves.csv out/lights.lp picture.png plot.svg found.json; do
    [ -e "$WORK/in/$name" ] || echo "old $name" >"$WORK/in/$name"
  done
}

mkdir "$WORK/in" "$WORK/before"
(cd "$WORK/in" && make_ball) || exit 1
if [ -f "$CASE/setup" ]; then
  (cd "$WORK/in" && . "$CASE/setup") || exit 1
fi

listing >"$WORK/before/listing"
(cd "$WORK/in" && find . -type f | sort) >"$WORK/before/names"
speak
if [ -f "$CASE/files" ]; then
  (cd "$WORK/in" && find . -type f | sort) >"$WORK/names"
  comm -13 "$WORK/before/names" "$WORK/names" | sed 's,^\./,,' >"$WORK/new"
  diff "$CASE/files" "$WORK/new" || complain "other files than expected"
else
  listing | diff "$WORK/before/listing" - || complain "files appeared or changed"
fi
if [ -f "$CASE/check" ]; then
  (cd "$WORK/in" && . "$CASE/check") || complain "check failed"
fi
if [ ! -f "$CASE/files" ] && [ "$(cat "$CASE/exit" 2>/dev/null || echo 0)" != 0 ]; then
  old_outputs
  listing >"$WORK/before/listing"
  # a refusal for want of a folder may turn into another one now
  [ -f "$CASE/once" ] || speak
  listing | diff "$WORK/before/listing" - || complain "an old output changed, or a new one appeared"
fi
if [ "$bad" != 0 ]; then
  echo "--- stdout"
  head -c 2000 "$WORK/stdout"
  echo "--- stderr"
  head -c 2000 "$WORK/stderr"
fi
exit "$bad"
