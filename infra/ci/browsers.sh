#!/usr/bin/env bash
# Chromium, Firefox and a virtual screen from Debian's packages, where they are absent and we may install them.
# Of Chromium the headless shell, where it is packaged: it opens a page for a third of the time.
set -euo pipefail
missing=()
command -v chromium-headless-shell >/dev/null || missing+=(chromium-headless-shell)
command -v firefox-esr >/dev/null || missing+=(firefox-esr)
command -v Xvfb >/dev/null || missing+=(xvfb libgl1-mesa-dri)
[ ${#missing[@]} -eq 0 ] && exit 0
if ! command -v apt-get >/dev/null; then
  command -v chromium >/dev/null && exit 0
  echo "Downloading Playwright's Chromium. Tests in Firefox need firefox-esr and Xvfb, and are skipped without them."
  exec .venv/bin/python -m playwright install --only-shell chromium
fi

run=()
if [ "$(id -u)" -ne 0 ]; then
  if ! sudo -n true 2>/dev/null; then
    [ "${missing[*]}" = chromium-headless-shell ] && command -v chromium >/dev/null && exit 0
    echo "The browser tests need: apt-get install ${missing[*]}"
    exit 1
  fi
  run=(sudo -n)
fi
echo "Installing ${missing[*]} and their dependencies with apt-get, for the whole system"
"${run[@]}" apt-get update -qq -o Acquire::Retries=3
packages=()
for package in "${missing[@]}"; do
  if [ "$package" = chromium-headless-shell ] && ! apt-cache show "$package" >/dev/null 2>&1; then
    command -v chromium >/dev/null && continue
    package=chromium
  fi
  packages+=("$package")
done
[ ${#packages[@]} -eq 0 ] && exit 0
"${run[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq -o Acquire::Retries=3 "${packages[@]}"
