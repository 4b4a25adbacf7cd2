// Spark: https://github.com/sparkjsdev/spark

import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";
import * as THREE from "three";
import { install, LOW_PASS_PX2 } from "./bench.mjs";
import { makeCamera, makeRenderer, place } from "./three.mjs";

async function start(url, camera) {
  const renderer = makeRenderer(camera);
  const scene = new THREE.Scene();
  const view = makeCamera(camera);
  // By default Spark blurs by 0.3 px2 and lowers the opacity instead, which is another picture.
  scene.add(new SparkRenderer({ renderer, preBlurAmount: LOW_PASS_PX2, blurAmount: 0.0 }));
  const mesh = new SplatMesh({ url });
  await mesh.initialized;
  scene.add(mesh);
  const render = (pose) => {
    place(view, pose);
    renderer.render(scene, view);
  };
  return { canvas: renderer.domElement, gl: renderer.getContext(), render };
}

install(start);
