#!/bin/sh
# Make bldsimp/compare/three-VERSION.min.js: the parts of three.js that the page of `bldsimp compare` uses, in one
# script that defines THREE, with its license as its head.
#
# usage: sh .ci/three.sh [VERSION]      (needs npm; afterwards name the file in bldsimp/compare/page.py)
set -eu
cd "$(dirname "$0")/.."
version=${1:-0.187.0}
target=$PWD/bldsimp/compare
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-save --prefix . "three@$version" esbuild@0.28.2
cat >viewer.js <<'JS'
export {
  BufferAttribute, BufferGeometry, Color, ColorManagement, DataTexture, DoubleSide, FloatType, GLSL3, Group, Mesh,
  PerspectiveCamera, RedFormat, Scene, ShaderMaterial, Spherical, Vector2, Vector3, WebGLRenderer,
} from "three";
export { TrackballControls } from "three/addons/controls/TrackballControls.js";
JS
cp node_modules/three/LICENSE "$target/three-LICENSE.txt"
{
    printf '/*!\n@license three.js %s, minified by esbuild: made by .ci/three.sh\nSPDX-License-Identifier: MIT\n\n' "$version"
    cat node_modules/three/LICENSE
    printf '*/\n'
    node_modules/.bin/esbuild viewer.js --bundle --minify --format=iife --global-name=THREE --target=es2020 \
        --legal-comments=none --log-level=warning
} >"$target/three-$version.min.js"
