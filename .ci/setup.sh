# shellcheck shell=bash
# Shared by run, test and .ci/run: Debian packages and the release build. Sourced; expects `set -euo pipefail`.
# Everything it says goes to standard error.

project_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build_dir=$project_dir/build/release
# shellcheck disable=SC2034  # Used by run.
program=$build_dir/apps/voropack/voropack

say() { printf '%s\n' "$*" >&2; }

# list_packages GROUP...: the packages of these groups of packages.txt, one a line.
list_packages() {
  awk -v groups=" $* " '
    /^# group:/ { wanted = index(groups, " " $3 " ") > 0; next }
    /^[^#]/     { if (wanted) print $1 }' "$project_dir/packages.txt"
}

# install_packages GROUP...: installs what is missing.
install_packages() {
  local missing=() package
  while read -r package; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done < <(list_packages "$@")
  [ ${#missing[@]} -gt 0 ] || return 0

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { say "These packages are missing and sudo is not there to install them: ${missing[*]}"; exit 2; }
    as_root=(sudo)
  fi
  say "Installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q >&2
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}" >&2
}

# is_newer STAMP PATH...: whether anything at or under the paths changed after STAMP was made.
is_newer() {
  local stamp=$1
  shift
  [ ! -e "$stamp" ] || [ -n "$(find "$@" -newer "$stamp" -print -quit)" ]
}

# build_release STAMP TARGET [CMAKE OPTION...]: configures and builds TARGET of the release preset.
build_release() {
  local stamp=$1 target=$2 started
  shift 2
  mkdir -p "$build_dir"
  started=$(mktemp "$build_dir/.started.XXXXXX")  # A file changed during the build must count as newer.
  (cd "$project_dir" && cmake --preset release "$@" && cmake --build --preset release --target "$target") >&2 || {
    rm -f "$started"
    say "The build failed."
    exit 70
  }
  mv "$started" "$stamp"
}
