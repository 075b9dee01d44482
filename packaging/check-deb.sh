#!/bin/bash
# Installs a package into an empty Debian, runs the tools and a small run there, and takes the package away again.
#   check-deb.sh FILE.deb EXAMPLE.json ROOT       ROOT: a folder to make, removed afterwards
# As root. The Debian is as this machine's (its release, its sources of packages).
set -eu
deb=$1 example=$2 root=$3
[ "$(id -u)" -eq 0 ] || { echo "an empty Debian is made as root" >&2; exit 1; }
command -v mmdebstrap >/dev/null || { echo "needs mmdebstrap" >&2; exit 1; }
. /etc/os-release
sources=()
for f in /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources; do [ ! -e "$f" ] || sources+=("$f"); done
options=()
while read -r f; do options+=("--aptopt=$f"); done < <(grep -lsE '^Acquire' /etc/apt/apt.conf /etc/apt/apt.conf.d/*)

rm -rf "$root"
trap 'rm -rf "$root"' EXIT
echo "An empty $PRETTY_NAME ..."
mmdebstrap --quiet --variant=apt "${options[@]}" "$VERSION_CODENAME" "$root" "${sources[@]}"
echo "  $(du -sh "$root" | cut -f1)"
cp "$deb" "$root/root/physmas.deb"
cp "$example" "$root/root/example.json"
cp /etc/resolv.conf "$root/etc/resolv.conf"
cat >"$root/root/check.sh" <<'END'
set -eu
export DEBIAN_FRONTEND=noninteractive
find / -xdev -type f | sort >/root/before
apt-get update -qq
apt-get install -qq -y --no-install-recommends ./physmas.deb make >/root/install.log 2>&1 || { cat /root/install.log; exit 1; }
dpkg --verify physmas
for tool in /usr/bin/pm-*; do
  "$tool" --version
  [ -s "/usr/share/man/man1/${tool##*/}.1.gz" ] || [ -e /etc/dpkg/dpkg.cfg.d/docker ]
  bash -n "/usr/share/bash-completion/completions/${tool##*/}"
done
mkdir scene && cd scene
pm-scene synth ../example.json --out bundle --quiet
make -f /usr/share/physmas/physmas.mk run SCENE=bundle/scene.json RUN=run SET=screening.initial=2
[ -s run/final.mp4 ]
make -f /usr/share/physmas/physmas.mk run SCENE=bundle/scene.json RUN=run SET=screening.initial=2 | grep 'Nothing to do'
apt-get purge -qq -y physmas >/root/purge.log 2>&1 || { cat /root/purge.log; exit 1; }
left=$(find / -xdev -path /root -prune -o -name '*physmas*' -print -o -path '/usr/bin/pm-*' -print)
[ -z "$left" ] || { echo "Left behind: $left"; exit 1; }
END
# Mounts of its own, which end with it.
unshare --mount --fork bash -c 'mount -t proc proc "$1/proc" && exec chroot "$1" /bin/bash -c "cd /root && exec bash check.sh"' check "$root"
echo "Installed, run and removed in an empty $PRETTY_NAME."
