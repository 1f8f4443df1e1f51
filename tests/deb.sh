# deb.sh BUILD [contents]: the Debian package of a build holds what it should and declares what it links.
#
# With `contents` that is all. Without, and as root, it is also installed in a fresh Debian 12 root
# with nothing but what it declares, estimates the light of a recorded frame there and is removed
# again, leaving nothing. That part needs debootstrap, the network (DEB_MIRROR, DEB_SUITE) and minutes;
# DEB_ROOT is the folder of a root that was made before, to be copied.
set -eu
build=$(cd "$1" && pwd)
contents=${2:-}
for tool in dpkg-deb dpkg-shlibdeps file; do
  if ! command -v $tool > /dev/null; then
    echo "skipped: no $tool; the packages dpkg-dev and file are needed"
    exit 77
  fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
complain() { echo "$*"; failed=1; }
value() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }

# what is built is packed: the name of a generator without a target `preinstall` keeps make out of it
(cd "$build" && cpack -G DEB -B "$work/packed" -D CPACK_CMAKE_GENERATOR=Ninja) > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
deb=$(echo "$work"/packed/halflight_*.deb)
dpkg-deb --contents "$deb" | awk '$1 !~ /^d/ { print $6 }' | sed 's,^\./,/,' | sort > "$work/held"

# what it should hold, from the sources
lib=/usr/$(value CMAKE_INSTALL_LIBDIR)
{
  echo /usr/bin/halflight
  if [ "$(value BUILD_SHARED_LIBS)" = ON ]; then
    grep -x "$lib/libhalflight[.]so\(\|[.]0\|[.][0-9]*[.][0-9]*[.][0-9]*\)" "$work/held"
  else
    echo "$lib/libhalflight.a"
  fi
  for file in config config-version targets targets-release; do
    echo "$lib/cmake/halflight/halflight-$file.cmake"
  done
  echo "$lib/pkgconfig/halflight.pc"
  grep -L 'Internal, not installed' include/halflight/*.h | sed 's,^,/usr/,'
  "$build/halflight" --help | awk '/^  [a-z]/ { print "/usr/share/man/man1/halflight-" $1 ".1" }'
  echo /usr/share/man/man1/halflight.1
  echo /usr/share/bash-completion/completions/halflight
  echo /usr/share/zsh/vendor-completions/_halflight
  echo /usr/share/doc/halflight/copyright
  for schema in src/schema/*.schema.json; do
    echo "/usr/share/halflight/schema/${schema##*/}"
  done
} | sort > "$work/wanted"
diff "$work/wanted" "$work/held" || complain "< wanted, > in the package"

depends=$(dpkg-deb --field "$deb" Depends)
echo "$(wc -l < "$work/held") files, $(du -k "$deb" | cut -f 1) kB; Depends: $depends"
for name in libc6 libcairo2 libcminpack1 libjansson4 libmd0 libyaml-0-2 zlib1g; do
  case ", $depends" in
  *", $name ("* | *", $name,"* | *", $name") ;;
  *) complain "it does not declare $name" ;;
  esac
done
# linked PATTERN NAME: it is declared where the command links it, and nowhere else
linked() {
  local links=no declares=no
  ! readelf -d "$build/halflight" "$build"/libhalflight.so* 2> /dev/null | grep NEEDED | grep -q "$1" || links=yes
  ! echo "$depends" | grep -q "$2" || declares=yes
  [ $links = $declares ] || complain "$2: linked $links, declared $declares"
}
linked libopencv_ libopencv
linked libcamera libcamera
linked libapriltag libapriltag
linked libassimp libassimp
linked libstdc++ libstdc++
linked libgomp libgomp
if [ "$contents" = contents ] || [ $failed != 0 ]; then
  exit $failed
fi

# ---- a fresh root
root=$work/root
mirror=${DEB_MIRROR:-http://deb.debian.org/debian}
if [ -n "${DEB_ROOT:-}" ]; then
  cp -a "$DEB_ROOT" "$root"
else
  debootstrap --variant=minbase "${DEB_SUITE:-bookworm}" "$root" "$mirror" > "$work/log" 2>&1 ||
    { tail "$work/log"; exit 1; }
fi
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C DEBIAN_FRONTEND=noninteractive "$@"; }
# everything but what keeps account of packages
listing() {
  (
    cd "$root"
    find . -xdev \( -path ./dev -o -path ./proc -o -path ./sys -o -path ./tmp -o -path ./var/lib/dpkg -o -path ./var/lib/apt \
      -o -path ./var/cache -o -path ./var/log \) -prune -o \( -type f -exec cksum {} + \) -o -printf '%y %p %l\n' | sort
  )
}
for file in /etc/apt/apt.conf.d/* /etc/apt/sources.list; do
  [ ! -f "$file" ] || [ -z "${DEB_MIRROR:-}" ] || cp "$file" "$root$file"
done
for file in /etc/resolv.conf /etc/hosts; do
  [ ! -f $file ] || cp $file "$root$file"
done
inside apt-get update > "$work/log" 2>&1 || { tail "$work/log"; exit 1; }
# what it depends on first, so that what the package itself leaves can be told from it
mkdir "$root/tmp/in"
cp "$deb" "$root/tmp/halflight.deb"
cp fixtures/core-hdr/* "$root/tmp/in/"
names=$(echo "$depends" | tr ',' '\n' | sed 's/(.*//; s/|.*//' | tr -d ' ' | tr '\n' ' ')
# shellcheck disable=SC2086
inside apt-get install -y --no-install-recommends $names > "$work/log" 2>&1 || { tail "$work/log"; exit 1; }
listing > "$work/before"
inside dpkg -i /tmp/halflight.deb > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
while IFS= read -r path; do
  # a slim root may leave manual pages out
  [ -e "$root$path" ] || [ -L "$root$path" ] || grep -qs path-exclude "$root"/etc/dpkg/dpkg.cfg.d/* ||
    complain "$path is not installed"
done < "$work/held"
inside halflight --version
inside halflight estimate /tmp/in/frame.pfm --camera /tmp/in/camera.json --radius-m 0.02 --out /tmp/out
for file in light.json curves.csv lights.lp; do
  [ -s "$root/tmp/out/$file" ] || complain "estimate left no $file"
done
inside dpkg --purge halflight > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
listing > "$work/after"
diff "$work/before" "$work/after" || complain "< before it was installed, > after it was removed"
[ $failed = 0 ] && echo "installed, run and removed; nothing is left behind"
exit $failed
