// GaussianSplats3D: https://github.com/mkkellogg/GaussianSplats3D

import * as GaussianSplats3D from "@mkkellogg/gaussian-splats-3d";
import { install, LOW_PASS_PX2 } from "./bench.mjs";
import { makeCamera, makeRenderer, place } from "./three.mjs";

async function start(url, camera) {
  const renderer = makeRenderer(camera);
  const view = makeCamera(camera);
  view.up.set(0, -1, 0);
  const viewer = new GaussianSplats3D.Viewer({
    renderer,
    camera: view,
    selfDrivenMode: false,
    useBuiltInControls: false,
    ignoreDevicePixelRatio: true,
    sharedMemoryForWorkers: true,
    sceneRevealMode: GaussianSplats3D.SceneRevealMode.Instant, // no fade-in while we measure
    sphericalHarmonicsDegree: 0,
    kernel2DSize: LOW_PASS_PX2,
  });
  place(view, { position: [0, 0, -4], quaternion: [1, 0, 0, 0] });
  await viewer.addSplatScene(url, { showLoadingUI: false, progressiveLoad: false });
  const render = (pose) => {
    place(view, pose);
    viewer.update();
    viewer.render();
  };
  return { canvas: renderer.domElement, gl: renderer.getContext(), render };
}

install(start);
