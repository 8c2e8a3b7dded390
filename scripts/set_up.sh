#!/usr/bin/env bash
# Sets up everything this repository needs, and nothing that is there already:
#
#     scripts/set_up.sh         the package and what it needs to run
#     scripts/set_up.sh dev     and what its tests and checks need
#     scripts/set_up.sh EXTRA   and an extra of pyproject.toml
#
# Makes the virtual environment .venv with the package and tacos-validation installed editable, and sees to it that OpenGL works
# without a display. What belongs to the system (python3-venv, Mesa) comes from apt-get where rights allow;
# where they do not, a sentence says what to install. Safe to run twice, and at the same time as itself.
set -euo pipefail

extra="${1:-}"
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
venv="$root/.venv"
cd "$root"

readonly GL_PACKAGES=(libegl1 libegl-mesa0 libgl1-mesa-dri libgl1)
readonly SUPPORTED_PYTHON='import sys; sys.exit(sys.version_info < (3, 11))'

say() { printf '[set up] %s\n' "$*"; }

give_up() {
    printf '[set up] %s\n' "$@" >&2
    exit 1
}

# --- the system's packages ---------------------------------------------------------------------------------

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        env DEBIAN_FRONTEND=noninteractive "$@" </dev/null
    else
        sudo -n env DEBIAN_FRONTEND=noninteractive "$@" </dev/null
    fi
}

may_install() {
    command -v apt-get >/dev/null || return 1
    [ "$(id -u)" -eq 0 ] || { command -v sudo >/dev/null && sudo -n true 2>/dev/null; }
}

# Package lists are fetched only when the install fails without: they are missing in fresh containers.
apt_install() {
    may_install || return 1
    say "installing $* through apt-get"
    local install=(apt-get -qq -y -o DPkg::Lock::Timeout=300 --no-install-recommends install)
    as_root "${install[@]}" "$@" >/dev/null 2>&1 && return
    as_root apt-get -qq update || return 1
    as_root "${install[@]}" "$@" >/dev/null
}

# --- Python ------------------------------------------------------------------------------------------------

# Runs each name: a version manager's stand-in may be on the path for a Python that is not there.
find_python() {
    local name
    for name in python3 python3.11 python3.12 python3.13 python3.14 python; do
        if "$name" -c "$SUPPORTED_PYTHON" 2>/dev/null; then
            command -v "$name"
            return
        fi
    done
    return 1
}

make_venv() {
    local python version
    python="$(find_python)" || give_up \
        "No Python 3.11 or later was found." \
        "Install one, for example with: apt-get install python3.11 python3.11-venv"
    # Debian and Ubuntu keep ensurepip, without which a new environment has no pip, in a package of its own.
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        version="$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
        apt_install "python$version-venv" || give_up \
            "$python cannot make virtual environments, and there are no rights to install what it lacks." \
            "Ask an administrator for: apt-get install python$version-venv"
    fi
    say "making the virtual environment .venv with $("$python" --version) ($python)"
    "$python" -m venv --clear "$venv"
}

# What the installation depends on; it is repeated when any of it changes, the place included, since
# scripts of a virtual environment hold its path.
fingerprint() {
    {
        printf '%s\n' "$root" "$("$venv/bin/python" --version)"
        cat pyproject.toml plugins/tacos_validation/pyproject.toml scripts/set_up.sh
    } | sha256sum | cut -d' ' -f1
}

venv_works() {
    # A moved folder leaves the old path behind in the environment.
    grep -qsF "VIRTUAL_ENV=" "$venv/bin/activate" && grep -qsF "$venv" "$venv/bin/activate" &&
        "$venv/bin/python" -c "import pip; $SUPPORTED_PYTHON" 2>/dev/null
}

install_package() {
    local target=".${extra:+[$extra]}"
    say "installing the package and what it needs (pip install --editable '$target' --editable plugins/tacos_validation);" \
        "a few minutes on a slow line"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-input \
        --editable "$target" --editable plugins/tacos_validation ||
        give_up "pip could not install the package; its message stands above."
}

# --- OpenGL ------------------------------------------------------------------------------------------------

# Really opens a context: a library that can be found may still lack a driver. Says what answered, or why not.
try_gl() {
    "$venv/bin/python" -c '
import moderngl

context = moderngl.create_context(standalone=True, backend="egl")
print(f"OpenGL {context.version_code / 100:.1f} works:", context.info["GL_RENDERER"])
' 2>&1 | tail -n 1
}

see_to_gl() {
    local message
    message="$(try_gl)" && { say "$message"; return; }
    say "OpenGL does not work yet: $message"
    apt_install "${GL_PACKAGES[@]}" || give_up \
        "OpenGL without a display needs packages, and there are no rights or no apt-get to install them." \
        "Ask an administrator for: apt-get install ${GL_PACKAGES[*]}" \
        "(on other systems: Mesa's EGL library and its software driver)"
    message="$(try_gl)" || give_up \
        "OpenGL does not work although ${GL_PACKAGES[*]} are installed: $message"
    say "$message"
}

# --- a first camera ----------------------------------------------------------------------------------------

# Scores one camera in one house: a last check, which also compiles the loops over pixels. They are kept for all
# that follows; otherwise every worker of the first study would begin with that.
score_a_camera() {
    local folder study
    folder="$(mktemp -d)"
    study=(headset_quick --out "$folder/run" --workers 1 --quiet --set compare=null --set test=null)
    study+=(--set optimizer.use=optimizer.random --set optimizer.evaluations=1)
    study+=(--set study.episodes=1 --set study.blocks=1)
    say "scoring a first camera, which compiles what draws it; half a minute"
    TACOS_CACHE=off "$venv/bin/tacos-run" "${study[@]}" >"$folder/said" 2>&1 ||
        give_up "A first camera could not be scored:" "$(tail -n 20 "$folder/said")"
    rm -rf "$folder"
}

# --- all of it, once ---------------------------------------------------------------------------------------

if command -v flock >/dev/null; then
    exec 9<pyproject.toml # a lock on a file that is there anyway leaves nothing behind
    flock --nonblock 9 || { say "waiting for another set-up to finish"; flock 9; }
fi

stamp="$venv/.set-up${extra:+-$extra}"
venv_works || make_venv
if [ "$(cat "$stamp" 2>/dev/null)" != "$(fingerprint)" ]; then
    install_package
    see_to_gl
    score_a_camera
    fingerprint | tee "$stamp" >"$venv/.set-up" # all that an extra adds to is there as well
    say "done"
fi
