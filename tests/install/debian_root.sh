# Sourced by clean_roots and bare_root: roots that have Debian's smallest system, in namespaces that end with the script. Needs root,
# debootstrap and an archive of Debian (MIRROR names it).

release=bookworm  # what make_bare_root and open_root are for; a script may change it between roots
mirror="${MIRROR:-http://deb.debian.org/debian}"

fail() { echo "failed: $*" >&2; exit 1; }

# enter_namespaces SCRIPT ARGUMENT...: runs the script again, in namespaces in which its mounts and processes end with it.
enter_namespaces() {
  if [[ -z "${INSIDE_NAMESPACES:-}" ]]; then
    INSIDE_NAMESPACES=yes exec unshare --mount --pid --fork --kill-child --mount-proc "$@"
  fi
  # As the first process of its namespace it would ignore these.
  trap 'exit 130' INT TERM
}

# use_scratch DIRECTORY: keeps the bare root and what apt downloads there for the next time.
use_scratch() {
  command -v debootstrap > /dev/null || fail "there is no debootstrap (deploy/install-packages package)"
  mkdir -p "$1/archives" "$1/roots"
  scratch="$(cd "$1" && pwd)"
}

make_bare_root() {
  local bare="$scratch/bare_$release"
  if [[ -e "$bare/made" ]]; then return; fi
  rm -rf "$bare"
  debootstrap --variant=minbase "$release" "$bare" "$mirror" > "$bare.log" || fail "debootstrap: see $bare.log"
  touch "$bare/made"
}

# open_root NAME: a copy of the bare root that knows its packages, with what a container has mounted.
open_root() {
  local root="$scratch/roots/$1"
  rm -rf --one-file-system "$root"
  cp -a "$scratch/bare_$release" "$root"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  mount --bind "$root" "$root"  # unshare takes only what is mounted for the root of its namespaces
  mount -t proc proc "$root/proc"
  mount -t sysfs -o ro sysfs "$root/sys"
  mount --rbind /dev "$root/dev"
  mount --bind "$scratch/archives" "$root/var/cache/apt/archives"
  in_root "$1" apt-get -q update > "$scratch/$1.log"
}

# close_root NAME: removes it.
close_root() {
  local root="$scratch/roots/$1"
  umount --lazy --recursive "$root"
  rm -rf --one-file-system "$root"
}

# in_root NAME COMMAND...: with what `environment` has, and of this environment no more than the way to the archive.
environment=()
in_root() {
  local root="$scratch/roots/$1"
  shift
  chroot "$root" /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    ${http_proxy:+http_proxy="$http_proxy"} "${environment[@]}" "$@"
}

step() { printf '\n== %s\n' "$*"; }
