// What the two viewers on three.js share: a renderer without antialiasing, and the camera.

import * as THREE from "three";
import { fieldOfView } from "./bench.mjs";

export function makeRenderer(camera) {
  const renderer = new THREE.WebGLRenderer({ antialias: false });
  renderer.setPixelRatio(1);
  renderer.setSize(camera.width_px, camera.height_px);
  renderer.setClearColor(0x000000, 1);
  document.body.appendChild(renderer.domElement);
  return renderer;
}

export function makeCamera(camera) {
  return new THREE.PerspectiveCamera(
    fieldOfView(camera),
    camera.width_px / camera.height_px,
    camera.near,
    camera.far,
  );
}

export function place(view, pose) {
  view.position.fromArray(pose.position);
  view.quaternion.fromArray(pose.quaternion);
  view.updateMatrixWorld();
}
