# manual.sh HALFLIGHT: manual pages and completion say what --help says, for every verb and option.
set -eu
halflight=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
complain() { echo "$*"; failed=1; }

"$halflight" help --completion bash > "$work/halflight.bash"
"$halflight" help --completion zsh > "$work/_halflight"
bash -n "$work/halflight.bash"
# shellcheck disable=SC1091
. "$work/halflight.bash"

# completed WORD...: what completion offers for the last of the words
completed() {
  COMP_WORDS=(halflight "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _halflight 2> /dev/null || true
  printf '%s\n' "${COMPREPLY[@]}"
}

verbs=$("$halflight" --help | awk '/^  [a-z]/ { print $1 }')
test "$(echo "$verbs" | wc -l)" -gt 10
offered=$(completed '' | grep -v '^--')
test "$offered" = "$verbs" || complain "completion offers other verbs: $offered"
"$halflight" help --man > "$work/page"
for verb in $verbs; do
  grep -q "halflight.*-$verb (1)" "$work/page" || complain "halflight(1) does not name $verb"
  "$halflight" help "$verb" --man | sed 's/\\-/-/g' > "$work/page-$verb"
  grep -q '^\.SH NAME' "$work/page-$verb" || complain "$verb: its page has no name"
  grep -qF -- "    '$verb:" "$work/_halflight" || complain "$verb: not in the zsh completion"
  completed "$verb" -- > "$work/offered"
  options=$("$halflight" "$verb" --help | grep -oE '^  --[a-z0-9-]+' | tr -d ' ' || true)
  for option in $options; do
    grep -qF -- "\\fB$option\\fR" "$work/page-$verb" || complain "$verb: its page lacks $option"
    grep -qxF -- "$option" "$work/offered" || complain "$verb: completion lacks $option"
    grep -qF -- "'$option[" "$work/_halflight" || complain "$verb: the zsh completion lacks $option"
  done
done
test "$(completed estimate --lobe f)" = foreshortened || complain "--lobe f is not completed"
for shell in zsh mandoc; do
  command -v $shell > /dev/null || echo "$shell is not here: not checked with it"
done
if command -v zsh > /dev/null; then
  zsh -n "$work/_halflight" || complain "zsh cannot read its completion"
fi
if command -v mandoc > /dev/null; then
  for page in "$work"/page*; do
    mandoc -Tlint -W error "$page" || complain "$page is malformed"
  done
fi
exit $failed
