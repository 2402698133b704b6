# The command in a root, against a server there: a scene is imported, a ray cast at it; pages and completion are where they belong.
model="$1"
fail() { echo "failed: $*" >&2; exit 1; }

[[ "$(getent passwd sightline | cut -d: -f6,7)" == /var/lib/sightline:/usr/sbin/nologin ]] || fail "the server's user: $(getent passwd sightline)"
[[ "$(stat -c '%U %a' /var/lib/sightline)" == "sightline 700" ]] || fail "the data directory is open to others"
sightlined --config /etc/sightline/sightlined.toml --check-config > /dev/null
[[ -s /usr/lib/systemd/system/sightlined.service ]]
# deb-systemd-helper has enabled it for the next boot.
[[ -L /etc/systemd/system/multi-user.target.wants/sightlined.service ]] || fail "the unit is not enabled"

sightline --version
sightline scene import engine "$model"
said="$(echo 0,500,0,0,-1,0 | sightline cast engine --in - --out - | tail -n 1)"
[[ "$said" =~ ^[0-9] ]] || fail "no hit: $said"
echo "hit: $said"

zgrep -q '^\.SH NAME' /usr/share/man/man1/sightline-cast.1.gz || fail "sightline-cast has no manual page"
zgrep -q 'data.*dir' /usr/share/man/man8/sightlined.8.gz || fail "sightlined has no manual page"
source /usr/share/bash-completion/completions/sightline
complete -p sightline
