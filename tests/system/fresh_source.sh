# The part of tests/system/fresh_machine that plays from a clone of the repository. Sourced by it, with the Debian in $root: an ordinary user
# runs deploy/play without the packages it needs, then with sudo, then a second time.
# shellcheck shell=bash disable=SC2154  # variables of fresh_machine

readonly home=/srv/player page_port=8191 daemon_port=47911  # a player of this machine may have the usual ones

as_player() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME="$home" USER=player LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    ${NODE_EXTRA_CA_CERTS:+NODE_EXTRA_CA_CERTS="$home/certificates.pem"} \
    chroot --userspec=player:player "$root" sh -c 'cd ~/hapticd && exec "$@"' sh "$@"
}

# A clone as an ordinary user has it. What npm is told to trust here, it is told there.
make_player() {
  # shellcheck disable=SC2016  # for the shell inside to expand
  inside "$root" sh -c 'id player || useradd --create-home --home-dir "$0" --shell /bin/bash player' $home && rm -rf "$root$home/hapticd" &&
    git -c safe.directory='*' clone --quiet --no-hardlinks "file://$project" "$root$home/hapticd" &&
    if [[ -n ${NODE_EXTRA_CA_CERTS:-} ]]; then cp "$NODE_EXTRA_CA_CERTS" "$root$home/certificates.pem"; fi &&
    inside "$root" chown -R player:player $home
}

# deploy/play where the user may not install: it names what an administrator has to, and apt knows all of it.
refuse_without_sudo() {
  local code=0 needed
  as_player deploy/play --no-sound >"$log" 2>&1 || code=$?
  ((code == 3)) || { cat "$log" >&2 && fail "deploy/play without sudo ended with $code, not 3"; }
  read -ra needed < <(sed -n 's/^ *apt-get install --no-install-recommends //p' "$log")
  ((${#needed[@]} > 5)) || { cat "$log" >&2 && fail 'deploy/play without sudo names no packages'; }
  apt_get install -s "${needed[@]}" >/dev/null || fail 'apt does not know the packages that deploy/play names'
  echo "without sudo: exit 3, and ${#needed[@]} packages named that an administrator has to install"
}

allow_sudo() {
  apt_get install sudo && echo 'player ALL=(ALL) NOPASSWD: ALL' >"$root/etc/sudoers.d/player"
}

# Plays for a few seconds. Each line of the log has the second it came at; the last tells when a script of the page was served.
play_from_source() {
  local began=$EPOCHREALTIME
  as_player deploy/play --no-sound --web-port $page_port --for 8 -- --listen 127.0.0.1:$daemon_port 2>&1 |
    while IFS= read -r line; do printf '%.1f %s\n' "$(since "$began")" "$line"; done >"$log" &
  local player=$!
  until fetch_page $page_port >/dev/null 2>&1; do
    kill -0 "$player" 2>/dev/null || { tail -40 "$log" >&2 && fail 'deploy/play'; }
    sleep 0.2
  done
  served=$(since "$began")
  wait "$player" || { tail -40 "$log" >&2 && fail 'deploy/play'; }
  grep -q ' It plays' "$log" || { tail -40 "$log" >&2 && fail 'deploy/play does not say that it plays'; }
}

since() {
  awk -v a="$1" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.1f", b - a }'
}

line() {
  printf '%-52s %6.1f s\n' "$1" "$2"
}

# The figures, and the machine, for tests/results.
report() {
  local machine
  machine=$(as_player build/play/bin/hapticd doctor --seconds 0 --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["machine"])')
  cat <<END
# From the source on a fresh Debian

$machine, load $load when it began. Commit $(git -c safe.directory="*" -C "$root$home/hapticd" rev-parse --short HEAD). Written by \`tests/system/fresh_machine --from-source --write\`.

A minimal Debian, a clone of the repository, an ordinary user, and \`deploy/play\` until a browser gets the page of the viewer.

| step | s |
|---|---:|
| packages: lists, download and installation | $packages_s |
| build | $build_s |
| start, until the page is served | $start_s |
| first \`deploy/play\` altogether | $first_s |
| second \`deploy/play\` | $second_s |

$without
END
}

# What any machine has, and apt and sudo look for.
mkdir -p "$root/dev/pts"
mount -t devpts -o newinstance,ptmxmode=0666,mode=620,gid=5 devpts "$root/dev/pts"
echo "127.0.0.1 localhost $(uname -n)" >"$root/etc/hosts"
load=$(cut -d' ' -f1 /proc/loadavg)
timed 'package lists' apt_get update
timed 'a clone for an ordinary user' make_player
without=$(refuse_without_sudo)
echo "$without"
timed 'sudo' allow_sudo
play_from_source
first_s=$served
packages_s=$(awk '/ building for the first time/ { print $1; exit }' "$log")
build_s=$(awk -v from="${packages_s:?deploy/play builds nothing}" '/ building: 100 %/ { to = $1 } END { printf "%.1f", to - from }' "$log")
start_s=$(awk -v all="$first_s" -v a="$packages_s" -v b="$build_s" 'BEGIN { printf "%.1f", all - a - b }')
line 'packages' "$packages_s"
line 'build' "$build_s"
line 'start, until the page is served' "$start_s"
play_from_source
second_s=$served
line 'second start, until the page is served' "$second_s"
if $write; then report >"$project/tests/results/fresh_source.md"; fi
echo 'passed'
