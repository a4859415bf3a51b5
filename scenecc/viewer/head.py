"""What scenecc adds to the head of viser's page: its title, styles, and a script that corrects shadows."""

from __future__ import annotations

from html import escape
from typing import Final

TREE: Final = '<i class="scenecc-tree"></i>'
"""Marks the container of the object tree: its buttons look like rows, and its folders like branches."""


def titled(page: str, title: str) -> str:
    """Returns viser's page with another title and with these styles, which viser has no options for."""
    page = page.replace("<title>Viser</title>", f"<title>{escape(title)}</title>{_STYLE}{_SCRIPT}", 1)
    # viser's script replaces the text as soon as it runs.
    return page.replace('<div id="root"></div>', '<div id="root">Loading the viewer</div>', 1)


_STYLE: Final = """<style>
/* every loop of a recording would begin viser's fade-in again */
canvas { opacity: 1 !important }
/* a page needs no GPU, and this notice covers the scene */
#webgl-software-rendering { display: none }
div:has(> * > .scenecc-tree) {
  .mantine-Button-root { height: 1.7em !important; padding: 0 0.5em; color: inherit; }
  .mantine-Button-root[style*="-gray-"] { background: none }
  .mantine-Button-root[style*="-gray-"]:hover { background: #8883 }
  .mantine-Button-root[style*="-orange-"] { color: #000; font-weight: 600 }
  .mantine-Button-inner { justify-content: flex-start }
  div:has(> .mantine-Button-root) { margin: 0 0.3em !important; padding: 0 !important }
  [data-with-border] {
    border: 0; margin: 0 0 0 0.5em !important; padding: 0;
    > .mantine-Paper-root { position: static; transform: none; display: flex; flex-direction: row-reverse;
      justify-content: flex-end; gap: 0.4em; padding: 0.15em 0.3em; background: none }
    > .mantine-Paper-root svg { margin: 0.15em 0 0; transform: rotate(180deg) }
    > .mantine-Paper-root svg.tabler-icon-chevron-down { transform: rotate(-90deg) }
    > .mantine-Paper-root:hover { background: #8883 }
    > .mantine-Paper-root + div { margin-left: 0.65em; border-left: 1px solid #8886;
      > div, > div > div { padding: 0 !important } }
    > .mantine-Paper-root + div + div { display: none !important }
    /* a closed folder shows the selected row in it, and no other */
    > div[aria-hidden="true"]:has([style*="-orange-"]) { display: block !important; height: auto !important;
      opacity: 1 !important; div:has(> .mantine-Button-root[style*="-gray-"]) { display: none }
      [data-with-border]:not(:has([style*="-orange-"])) { display: none } }
  }
}
</style>"""

_SCRIPT: Final = """<script>
/* viser has no option for what is set here. */
setInterval(() => {
  const drawn = window.__viserMutable;
  let changed = false;
  /* shadows without a bias for their resolution leave stripes on lit faces */
  for (const light of drawn?.scene?.children ?? []) {
    if (!light.isDirectionalLight || !light.castShadow) continue;
    const { camera, mapSize } = light.shadow, bias = 3 * (camera.right - camera.left) / mapSize.width;
    changed ||= light.shadow.normalBias !== bias;
    light.shadow.normalBias = bias;
  }
  /* collision shapes often lie in the surfaces of visuals: their depth is that of a nearer place on the same ray */
  for (const [path, node] of Object.entries(drawn?.nodeRefFromName ?? {})) {
    if (path.startsWith("/light "))
      node?.traverse((light) => {
        if (!light.castShadow || !light.shadow || light.shadow.normalBias) return;
        light.shadow.normalBias = 0.01;
        changed = true;
      });
    if (path === "/selected" || path === "/contacts" || path.startsWith("/overlap "))
      /* boxes around bodies and arrows of contacts are visible through what is in front */
      node?.traverse((line) => {
        if (!line.material?.depthTest) return;
        line.material.depthTest = false;
        line.material.transparent = changed = true;
        line.renderOrder = 1e4;
      });
    if (!path.includes("/collision ")) continue;
    node?.traverse(({ material }) => {
      if (!material?.isMeshStandardMaterial || material.userData.isNearer) return;
      material.userData.isNearer = changed = true;
      material.onBeforeCompile = (shader) => {
        shader.vertexShader = shader.vertexShader.replace("#include <project_vertex>", `#include <project_vertex>
          vec4 nearer = projectionMatrix * vec4(mvPosition.xyz * 0.995, 1.0);
          gl_Position.z = nearer.z * gl_Position.w / nearer.w;`);
      };
      material.needsUpdate = true;
    });
  }
  if (changed) drawn.requestRender?.();
}, 200);
</script>"""
