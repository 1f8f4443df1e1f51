# reference.sh FOLDER VERSION: the API reference as FOLDER/html, by doxygen; any complaint fails it.
#
# A member that its name explains needs no words, so doxygen's wish for a text beside every one of
# them is no complaint; one beside every function, struct, enumeration and macro is.
set -eu
cd "$(dirname "$0")/../.."
mkdir -p "$1"
HL_DOC=$1 HL_VERSION=$2 doxygen src/doc/Doxyfile > "$1/log" 2>&1 || true
if grep -vE 'Member .* \((variable|enumvalue)\) .* is not documented' "$1/log"; then
  exit 1
fi
for page in index light_8h structhl__light; do
  test -s "$1/html/$page.html" || { echo "no $page.html"; exit 1; }
done
grep -q 'hl_light_estimate' "$1/html/light_8h.html"
