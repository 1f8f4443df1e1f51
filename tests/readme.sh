#!/bin/sh
# readme.sh BUILD CC SAME_PICTURE [update] [PAGE.md ...]: README.md does what it says, or those pages,
# one after another in one copy of the project.
#
# Every ```sh block is run, in order, in a copy of the project's top folder made of links where
# build/ is BUILD and `cc` is CC; the ```c block is direction.c there. A ```text block is what the
# ```sh block before it printed: words must be equal, numbers near, lines of times are not looked
# at; `text varies` is not compared at all. Of the blocks that install packages, only what follows
# the build is run here: .ci/run takes them from README.md whole.
# With `update`, the page and the picture of README.md are rewritten from what was printed instead (the
# picture needs python3-pil).
set -u
build=$(cd "$1" && pwd) cc=$(command -v "$2") same_picture=$3
shift 3
update=
if [ "${1:-}" = update ]; then
  update=update
  shift
fi
project=$(cd "$(dirname "$0")/.." && pwd)
picture=fixtures/coated-oblique/result.jpg
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
LC_ALL=C
export LC_ALL
bad=0
page=

complain()
{
  echo "${page#"$project"/}: $*"
  bad=1
}

mkdir "$work/top" "$work/bin"
for entry in "$project"/*; do
  case ${entry##*/} in
  build* | out) ;;
  *) ln -s "$entry" "$work/top/" ;;
  esac
done
ln -s "$build" "$work/top/build"
ln -s "$cc" "$work/bin/cc"
PATH=$work/bin:$PATH

# near GOT EXPECTED: line by line, word by word
near()
{
  awk -v expected="$2" '
    function is_number(w) { return w ~ /^[-+]?[0-9]*[.]?[0-9]+(e[-+]?[0-9]+)?$/ }
    function trim(w) { sub(/[),;:%]+$/, "", w); sub(/^\(/, "", w); return w }
    function abs(x) { return x < 0 ? -x : x }
    {
      if ((getline want <expected) <= 0) { print "line too many: " $0; bad = 1; exit }
      if ($1 == "time" && want ~ /^time /) next
      n = split(want, w)
      same = n == NF
      for (i = 1; i <= n && same; i++) {
        a = trim($i); b = trim(w[i])
        if (a == b) continue
        same = is_number(a) && is_number(b) && abs(a - b) <= 0.0002 + 0.02 * abs(b)
      }
      if (!same) { print "printed:  " $0; print "it says:  " want; bad = 1 }
    }
    END {
      if (!bad && (getline want <expected) > 0) { print "missing: " want; bad = 1 }
      exit bad
    }' "$1"
}

# Blocks go to files named by number and kind; a line of the page that is not in one is kept.
split_page()
{
  rm -rf "$work/blocks"
  mkdir "$work/blocks"
  awk -v to="$work/blocks/" '
    /^```/ && !inside { inside = 1; file = sprintf("%s%02d.%s", to, ++n, substr($1, 4)); printf "" >file
                        if ($2 != "") print $2 >(file ".mark"); next }
    /^```/ { inside = 0; close(file); next }
    inside { print >file }' "$page"
}

run_blocks()
{
  installing=0
  last=
  for block in "$work"/blocks/*; do
    case $block in
    *.mark) ;;
    *.c)
      cp "$block" "$work/top/direction.c" ;;
    *.cmake)
      # what it shows is what tests/consumer does, and install.sh runs that
      sed 's/\<direction\>/consumer/g' "$block" | while IFS= read -r line; do
        grep -qxF "$line" "$project/tests/consumer/CMakeLists.txt" || echo "$line"
      done >"$work/unknown"
      [ ! -s "$work/unknown" ] || complain "not in tests/consumer/CMakeLists.txt: $(cat "$work/unknown")" ;;
    *.sh)
      last=$block
      if grep -q apt-get "$block"; then
        installing=$((installing + 1))
        sed '/^apt-get /d; /^cmake /d; /^ctest /d' "$block" >"$work/run"
      else
        cp "$block" "$work/run"
      fi
      # the test of the frames ran before, and takes its time
      if grep -qx 'sh tests/fixtures.sh build/halflight' "$block" &&
        [ -n "$(find "$build/fixtures.txt" -newer "$build/halflight" 2>/dev/null)" ]; then
        cp "$build/fixtures.txt" "$block.printed"
        continue
      fi
      (cd "$work/top" && sh -e "$work/run") >"$block.printed" 2>"$work/stderr" || {
        complain "this failed: $(cat "$work/run")"
        tail -n 5 "$work/stderr" "$block.printed"
      } ;;
    *.text)
      if [ -e "$block.mark" ] || [ -n "$update" ]; then
        continue
      fi
      near "$last.printed" "$block" >"$work/differs" || {
        complain "other output of: $(cat "$last")"
        cat "$work/differs"
      } ;;
    esac
  done
}

# The page with what was printed.
rewrite_page()
{
  awk -v from="$work/blocks/" '
    /^```/ && !inside {
      inside = 1; kind = substr($1, 4); n++; print
      if (kind == "text") while ((getline line <last) > 0) print line
      if (kind == "sh") last = sprintf("%s%02d.sh.printed", from, n)
      next
    }
    /^```/ { inside = 0 }
    !inside || kind != "text"' "$page" >"$work/page.md" &&
    cp "$work/page.md" "$page"
}

if [ $# -gt 0 ]; then
  for page in "$@"; do
    page=$(cd "$(dirname "$page")" && pwd)/${page##*/}
    split_page
    run_blocks
    [ -z "$update" ] || rewrite_page
  done
  exit "$bad"
fi

page=$project/README.md
split_page
run_blocks
[ "$installing" = 2 ] || complain "$installing blocks install packages, two are expected"

if [ -n "$update" ]; then
  rewrite_page
  /usr/bin/python3 -c 'import sys; from PIL import Image
Image.open(sys.argv[1]).convert("RGB").save(sys.argv[2], quality=85, subsampling=0, optimize=True)' \
    "$work/top/out/photo.png" "$project/$picture" || bad=1
else
  grep -q "($picture)" "$project/README.md" || complain "does not show $picture"
  "$same_picture" "$work/top/out/photo.png" "$project/$picture" ||
    complain "$picture is not what the command draws"
fi
exit "$bad"
