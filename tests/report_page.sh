#!/bin/sh
# report_page.sh PAGE: what every page that `report` writes must hold, without a browser.
#   every picture has words, a width, a height and its bytes within the page; nothing is asked of a
#   network; tags are balanced; one heading of the first rank; language and title are stated.
set -u
page=$1
bad=0

complain()
{
  echo "$page: $*"
  bad=1
}

[ -s "$page" ] || { complain "is missing or empty"; exit 1; }
! grep -qiE 'https?://|@import|url\(' "$page" || complain "names something outside itself"
head -n 1 "$page" | grep -qi '^<!doctype html>$' || complain "has no doctype"
grep -q '<html lang="en">' "$page" || complain "has no language"
grep -q '<title>..*</title>' "$page" || complain "has no title"
grep -q '<meta name="viewport"' "$page" || complain "is not made for a phone"
! grep -q '{{' "$page" || complain "has a place of the template left"
! grep -qE '(nan|inf)[ ,<%]' "$page" || complain "shows a number that is none"
awk '
  function complain(text) { print text; bad = 1 }
  BEGIN {
    RS = "<"
    split("meta link img", words, " ")
    for (i in words) is_void[words[i]] = 1
  }
  NR == 1 || /^!/ { next }
  inside != "" && $0 !~ "^/" inside ">" { next } # style and script are no markup
  {
    end = index($0, ">")
    if (end == 0) { complain("a < without its >: <" substr($0, 1, 60)); next }
    tag = substr($0, 1, end - 1)
    name = tag
    sub(/[ \n\/].*/, "", name)
    if (substr(tag, 1, 1) == "/") {
      name = substr(tag, 2)
      inside = ""
      if (depth == 0 || stack[depth] != name) complain("</" name "> closes <" stack[depth] ">")
      else depth--
      next
    }
    count[name]++
    if (name == "img") {
      if (tag !~ / alt="[^"]/) complain("a picture without words")
      if (tag !~ / width="[1-9][0-9]*"/ || tag !~ / height="[1-9][0-9]*"/) complain("a picture without a size")
      if (tag !~ / src="data:image\/(png|svg\+xml);base64,[A-Za-z0-9+\/=]*"$/) complain("a picture from elsewhere")
    } else if (tag ~ / src=/) complain("<" name "> loads something")
    if (tag ~ / href=/ && tag !~ / href="data:,"/) complain("<" name "> refers to something")
    if (tag ~ / on[a-z]+=/) complain("<" name "> holds script")
    if (name == "svg" && tag !~ / aria-label="[^"]/) complain("a drawing without words")
    if (!(name in is_void) && tag !~ /\/$/) stack[++depth] = name
    if (name == "style" || name == "script") inside = name
  }
  END {
    if (depth != 0) complain("<" stack[depth] "> is not closed")
    if (count["h1"] != 1) complain(count["h1"] + 0 " headings of the first rank")
    exit bad
  }' "$page" || complain "is not well made"
exit "$bad"
