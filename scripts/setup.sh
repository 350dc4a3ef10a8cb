# Sourced by run.sh, test.sh and web.sh: goes to the root folder of the repository and installs
# missing packages on Debian 12, as root or with sudo. Arguments: further packages.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(g++ cmake ninja-build libeigen3-dev libtinyobjloader-dev libassimp-dev libcli11-dev
          nlohmann-json3-dev libtbb-dev libboost-dev robin-map-dev libepoxy-dev libglfw3-dev
          libimgui-dev libx11-dev libpng-dev pkg-config libegl1 libgl1-mesa-dri "$@")
missing=()
for p in "${packages[@]}"; do
  # Some packages of Node contain npm.
  [ "$p" = npm ] && command -v npm >/dev/null && continue
  dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing+=("$p")
done
if [ ${#missing[@]} -gt 0 ]; then
  sudo=
  [ "$(id -u)" -eq 0 ] || sudo=sudo
  echo "installing: ${missing[*]}"
  $sudo apt-get update -qq
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    "${missing[@]}" >/dev/null
fi
