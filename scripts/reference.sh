#!/usr/bin/env bash
# Builds the API reference of the public headers with Doxygen: out/reference/index.html. A warning
# is an error. Installs Doxygen on Debian if it is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if ! command -v doxygen >/dev/null; then
  sudo=
  [ "$(id -u)" -eq 0 ] || sudo=sudo
  $sudo apt-get update -qq
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    doxygen doxygen-awesome-css >/dev/null
fi

mkdir -p out
style=/usr/share/doxygen-awesome-css/doxygen-awesome.css
{
  cat docs/Doxyfile
  # The style is optional.
  if [ -f "$style" ]; then echo "HTML_EXTRA_STYLESHEET = $style"; fi
} | doxygen -
echo "out/reference/index.html"
