# An upgrade keeps settings that were changed, and scenes; removing the package keeps both; purging it keeps the scenes.
fail() { echo "failed: $*" >&2; exit 1; }
settings=/etc/sightline/sightlined.toml
scenes=/var/lib/sightline
uid="$(id -u sightline)"

# The same package with a later version and other settings.
dpkg-deb -R /packages/sightline-server_*.deb /tmp/later
sed -i 's/^Version: .*/Version: 99/' /tmp/later/DEBIAN/control
echo '# theirs' >> "/tmp/later$settings"
dpkg-deb -b /tmp/later /tmp/later.deb > /dev/null
echo '# ours' >> "$settings"
rm /etc/systemd/system/multi-user.target.wants/sightlined.service # as `systemctl disable` does

dpkg --force-confold -i /tmp/later.deb > /dev/null
[[ "$(dpkg-query -W -f '${Version}' sightline-server)" == 99 ]] || fail "there was no upgrade"
grep -q '^# ours' "$settings" && ! grep -q '^# theirs' "$settings" || fail "the upgrade has replaced the settings"
grep -q '^# theirs' "$settings.dpkg-dist" || fail "the new settings are not beside the old ones"
[[ ! -e /etc/systemd/system/multi-user.target.wants/sightlined.service ]] || fail "the upgrade has enabled the server again"
[[ "$(id -u sightline)" == "$uid" && -n "$(ls $scenes)" ]] || fail "the upgrade has changed user or scenes"

dpkg --remove sightline-server > /dev/null
[[ ! -e /usr/bin/sightlined && -s "$settings" && -n "$(ls $scenes)" ]] || fail "removing has left or taken too much"
dpkg --purge sightline-server > /tmp/said
[[ ! -e /etc/sightline && -n "$(ls $scenes)" ]] || fail "purging has left or taken too much"
grep -q "scenes are kept in $scenes" /tmp/said || fail "purging does not say where scenes are: $(cat /tmp/said)"
[[ -z "$(find /etc/systemd/system /var/lib/systemd -name '*sightline*' 2> /dev/null)" ]] || fail "traces of the unit are left"

# Back again, over scenes that are there.
dpkg -i /packages/sightline-server_*.deb > /dev/null
[[ "$(id -u sightline)" == "$uid" && -s "$settings" ]] || fail "it cannot be installed again"
echo "settings and scenes are kept as they should"
