#!/bin/sh
# Builds the wheel, installs it into a new virtual environment, and runs all of its checks.
#
#   bindings/python/ci.sh            # the profile `wheel`: small, and fast
#   DRYSTONE_PY_PROFILE=dev ...      # a debug build, which checks the engine's assertions too
set -eu
cd "$(dirname "$0")"
profile=${DRYSTONE_PY_PROFILE:-wheel}
venv=${DRYSTONE_PY_VENV:-$PWD/../../target/python-venv}
wheels=${DRYSTONE_PY_WHEELS:-$PWD/../../target/wheels}

skip() {
    echo "SKIPPED: $1: nothing of the Python bindings was checked" >&2
    exit 0
}

python=${PYTHON:-python3}
command -v "$python" > /dev/null || skip "no $python"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || skip "$python is older than 3.11"
rm -rf "$venv"
"$python" -m venv "$venv" || skip "$python has no venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check maturin numpy pytest hypothesis mypy \
    || skip "pip cannot install maturin, numpy, pytest, hypothesis and mypy (no network?)"

rm -f "$wheels"/drystone-*.whl
"$venv/bin/maturin" build --profile "$profile" --out "$wheels" --interpreter "$venv/bin/python"
wheel=$(ls "$wheels"/drystone-*.whl)
bytes=$(wc -c < "$wheel")
echo "wheel: $bytes bytes; the goal is below 4,000,000"
if [ "$profile" = wheel ] && [ "$bytes" -gt 4600000 ]; then
    echo "the wheel has more than 4.6 MB, which is more than it had" >&2
    exit 1
fi
"$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps "$wheel"

"$venv/bin/python" -m pytest tests
"$venv/bin/python" -m mypy --strict python/drystone tests examples
"$venv/bin/python" -m mypy.stubtest --mypy-config-file pyproject.toml drystone._drystone
echo "the Python bindings pass"
