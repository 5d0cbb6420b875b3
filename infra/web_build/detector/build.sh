#!/usr/bin/env bash
# Builds the board detector of the pages: the part of OpenCV that finds markers and ChArUco corners, as WebAssembly.
#
#     infra/web_build/detector/build.sh [folder]     # default .build/detector; about 10 minutes on two cores
#
# Writes opencv.js, opencv.wasm, opencv.json (versions, sizes, SHA-256) and LICENSE next to this script, which are committed:
# `make` needs neither a compiler nor this script. bindings.json lists the functions that the pages call.
# Needs Debian 12's packages emscripten (3.1.6), cmake and make, and pip and npm. The source is that of OpenCV's Python
# package of the same version as in requirements.lock, by its hash.
set -euo pipefail
PACKAGE=opencv-python-headless VERSION=5.0.0.93
SHA256=b82f9831daab90b725c7c1ee1b36cb5732c367096ac76d119e64e14eb70d5f3c
HERE=$(cd "$(dirname "$0")" && pwd)
WORK=$(realpath -m "${1:-.build/detector}")
export EMSDK=/usr/share/emscripten EMSCRIPTEN=/usr/share/emscripten NODE_PATH=$WORK/node_modules
export OPENCV_JS_WHITELIST=$HERE/bindings.json
mkdir -p "$WORK/build"

if [ ! -d "$WORK/opencv" ]; then
  # pip unpacks the source, and then fails because the package's own build system is not installed: it is not needed.
  mkdir -p "$WORK/download"
  echo "$PACKAGE==$VERSION --hash=sha256:$SHA256" > "$WORK/source.txt"
  TMPDIR=$WORK/download python3 -m pip download --quiet --no-deps --no-binary :all: --no-build-isolation --no-clean \
    --require-hashes --dest "$WORK/download" -r "$WORK/source.txt" > "$WORK/download.log" 2>&1 || true
  mv "$WORK"/download/*/"$PACKAGE"_*/opencv "$WORK/opencv"
  rm -rf "$WORK/download"
  # A namespace of a module that is not built
  sed -i 's/^using namespace cv::segmentation;.*$//' "$WORK/opencv/modules/js/src/core_bindings.cpp"
  # No file system and no names of C++ for debuggers; functions are not made from strings, so that no page needs `unsafe-eval`.
  sed -i -e 's/-s FORCE_FILESYSTEM=1 --use-preload-plugins/-s FILESYSTEM=0 -s DYNAMIC_EXECUTION=0 -s EXPORT_ES6=1 -s ENVIRONMENT=web,worker/' \
    -e 's/-s DEMANGLE_SUPPORT=1//' -e 's/-s TOTAL_MEMORY=128MB/-s INITIAL_MEMORY=64MB/' "$WORK/opencv/modules/js/CMakeLists.txt"
fi
# Debian's emscripten lacks the parser that it needs.
npm install --silent --no-save --prefix "$WORK" acorn@8.19.0

# Names of source files in messages, the same in whichever folder this is built.
prefixes="-fmacro-prefix-map=$WORK/opencv/=/usr/src/opencv-5.0.0/ -fmacro-prefix-map=$WORK/build/=/usr/src/build/"
options=(
  -DBUILD_LIST=core,imgproc,flann,geometry,features,objdetect,js -DBUILD_EXAMPLES=OFF -DBUILD_TESTS=OFF -DBUILD_PERF_TESTS=OFF
  -DBUILD_opencv_{dnn,photo,video,calib,ptcloud,stereo,3d}=OFF -DWITH_QUIRC=OFF
  "-DCMAKE_CXX_FLAGS_RELEASE=-Os -DNDEBUG" "-DCMAKE_C_FLAGS_RELEASE=-Os -DNDEBUG"
  -DCMAKE_TOOLCHAIN_FILE=$EMSCRIPTEN/cmake/Modules/Platform/Emscripten.cmake
)
python3 "$WORK/opencv/platforms/js/build_js.py" "$WORK/build" --emscripten_dir=$EMSCRIPTEN --build_wasm --simd --disable_single_file \
  --config="$HERE/bindings.json" --build_flags="-Os $prefixes" "${options[@]/#/--cmake_option=}" --config_only > "$WORK/configure.log" 2>&1
echo '""' > "$WORK/build/modules/core/version_string.inc"  # facts about the machine of the build
nice make -C "$WORK/build" -j2 opencv_js > "$WORK/make.log" 2>&1

cp "$WORK"/build/bin/opencv_js.js "$HERE/opencv.js"
cp "$WORK"/build/bin/opencv_js.wasm "$HERE/opencv.wasm"
chmod 644 "$HERE"/opencv.{js,wasm}
{
  cat "$WORK/opencv/COPYRIGHT" "$WORK/opencv/LICENSE"
  printf '\n\n==== OpenCV.js bindings (modules/js)\n\n'
  sed -n '/^\/\*M/,/^\/\/M\*\//p' "$WORK/opencv/modules/js/src/core_bindings.cpp"
  printf '\n\n==== FLANN (modules/flann)\n\n'
  sed -n '1,/\*\*\*\//p' "$WORK/opencv/modules/flann/include/opencv2/flann/flann_base.hpp"
  printf '\n\n==== zlib (3rdparty/zlib)\n\n'
  cat "$WORK/opencv/3rdparty/zlib/LICENSE"
  printf '\n\n==== musl\n\n'
  cat $EMSCRIPTEN/system/lib/libc/musl/COPYRIGHT
  printf '\n\n==== Emscripten (MIT), libc++ and compiler-rt of LLVM (Apache-2.0 with LLVM exceptions)\n\n'
  cat "$HERE/emscripten.LICENSE"
} > "$HERE/LICENSE"
python3 - "$HERE" "$PACKAGE" "$VERSION" "$SHA256" "$(em++ --version | grep -oE '[0-9]+\.[0-9]+\.[0-9]+' | head -1)" <<'PY'
import hashlib, json, pathlib, sys
here, package, version, source, emscripten = pathlib.Path(sys.argv[1]), *sys.argv[2:]
files = {name: hashlib.sha256((here / name).read_bytes()).hexdigest() for name in ("opencv.js", "opencv.wasm", "LICENSE")}
made = {"version": version, "license": "Apache-2.0", "bytes": (here / "opencv.wasm").stat().st_size, "sha256": files,
        "source": {"package": package, "sha256": source}, "emscripten": emscripten}
(here / "opencv.json").write_text(json.dumps(made, indent=2) + "\n")
PY
