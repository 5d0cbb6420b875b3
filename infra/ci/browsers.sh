#!/usr/bin/env bash
# Chromium, Firefox and a virtual screen from Debian's packages, where they are absent and we may install them.
set -euo pipefail
missing=()
command -v chromium >/dev/null || missing+=(chromium)
command -v firefox-esr >/dev/null || missing+=(firefox-esr)
command -v Xvfb >/dev/null || missing+=(xvfb libgl1-mesa-dri)
[ ${#missing[@]} -eq 0 ] && exit 0

run=()
if [ "$(id -u)" -ne 0 ]; then
  sudo -n true 2>/dev/null || { echo "The browser tests need: apt-get install ${missing[*]}"; exit 1; }
  run=(sudo -n)
fi
"${run[@]}" apt-get update -qq -o Acquire::Retries=3
"${run[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq -o Acquire::Retries=3 "${missing[@]}"
