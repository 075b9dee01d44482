#!/bin/bash
# Makes a Debian package of what `make install PREFIX=/usr` put into a folder, which it completes: dependencies, copyright,
# changelog, checksums.
#   make-deb.sh FOLDER VERSION MAINTAINER FILE.deb
set -eu
root=$(realpath "$1") version=$2 maintainer=$3 file=$4
export SOURCE_DATE_EPOCH
: "${SOURCE_DATE_EPOCH:=$(date +%s)}"

# dpkg knows what it installed.
rm "$root/usr/share/physmas/manifest"
strip --strip-unneeded --remove-section=.comment "$root"/usr/bin/pm-*
gzip -9n "$root"/usr/share/man/man1/*.1

doc=$root/usr/share/doc/physmas
{
  printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: PhysMAS\n\nFiles: *\n'
  sed -n 's/^Copyright (c) /Copyright: /p' "$doc/LICENSE"
  printf 'License: Expat\n'
  sed -n '/^Permission/,$p' "$doc/LICENSE" | sed 's/^$/./; s/^/ /'
} >"$doc/copyright"
rm "$doc/LICENSE"
gzip -9n >"$doc/changelog.gz" <<END
physmas ($version) unstable; urgency=medium

  * Version $version.

 -- $maintainer  $(date -uR -d "@$SOURCE_DATE_EPOCH")
END

# dpkg-shlibdeps wants a source package's control file beside it.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/debian"
echo 'Source: physmas' >"$work/debian/control"
libraries=$(cd "$work" && dpkg-shlibdeps -O "$root"/usr/bin/pm-* | sed -n 's/^shlibs:Depends=//p')

mkdir "$root/DEBIAN"
cat >"$root/DEBIAN/control" <<END
Package: physmas
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: $maintainer
Installed-Size: $(du -sk --apparent-size "$root/usr" | cut -f1)
Depends: $libraries
Recommends: make
Suggests: gnuplot-nox
Section: science
Priority: optional
Description: physical simulation of 3D Gaussian Splatting scenes
 PhysMAS turns a static 3D Gaussian Splatting scene and a motion prompt into
 a physically simulated 4D Gaussian sequence. It grounds objects and their
 parts in four views, gives every part its own constitutive law, simulates
 all objects in one Material Point Method domain, screens the results, and
 returns one audited rollout.
 .
 The tools pm-scene, pm-ground, pm-lift, pm-material, pm-candidates,
 pm-simulate, pm-render, pm-screen, pm-report and pm-eval read and write files;
 /usr/share/physmas/physmas.mk chains them with GNU Make. The solver and the
 renderer use AVX-512, AVX2 or SSE2, as wide as the processor has.
END
(cd "$root" && find usr -type f -printf '%P\n' | LC_ALL=C sort | sed 's,^,usr/,' | tr '\n' '\0' | xargs -0 md5sum) >"$root/DEBIAN/md5sums"
dpkg-deb --root-owner-group -Zxz --build "$root" "$file"
