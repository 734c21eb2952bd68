#!/bin/sh
# Make a folder with a Python for arm64 and all packages that Ghostball's engine imports, to be run by qemu.
# Also install qemu and a linker for arm64. Needs `make venv`, root, and Debian 12 or a similar system:
#     sudo tests/support/arm64.sh /tmp/arm64 && GHOSTBALL_ARM64=/tmp/arm64 make test-slow
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
python=$root/.venv/bin/python
imported='numpy|pydantic|pydantic_core|annotated-types|typing_extensions|typing-inspection|tomli_w|platformdirs'
imported="$imported|filelock|lazy-loader|packaging"
mkdir -p "$1/packages" && cd "$1"
export DEBIAN_FRONTEND=noninteractive
dpkg --add-architecture arm64
apt-get update -q
apt-get install -y -q --no-install-recommends qemu-user-static gcc-aarch64-linux-gnu libc6-dev-arm64-cross
(cd packages && apt-get download -q $(for name in libc6 libgcc-s1 libstdc++6 zlib1g libexpat1 libffi8 \
	python3.11-minimal libpython3.11-minimal libpython3.11-stdlib; do echo "$name:arm64"; done))
for package in packages/*.deb; do dpkg -x "$package" system; done
"$python" -m pip download -q --disable-pip-version-check --no-deps --dest packages --only-binary=:all: \
	--python-version 3.11 --platform manylinux2014_aarch64 \
	$(for glibc in 2_17 2_27 2_28; do echo "--platform manylinux_${glibc}_aarch64"; done) \
	$(grep -E "^($imported)==" "$root/constraints.txt")
mkdir -p site
for wheel in packages/*.whl; do "$python" -m zipfile -e "$wheel" site; done
