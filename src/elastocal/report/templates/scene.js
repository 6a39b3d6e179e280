(function () {
  "use strict";
  var box = document.getElementById("scene");
  var printer = document.getElementById("print");
  printer.hidden = false;
  printer.addEventListener("click", function () { window.print(); });

  var canvas = document.createElement("canvas");
  var webgl = canvas.getContext("webgl2") || canvas.getContext("webgl");
  var note = document.getElementById("scene-note");
  if (!webgl || typeof Plotly === "undefined") {
    note.textContent = "This device shows no 3D graphics; here are the same configurations as pictures.";
    return;
  }
  var lost = webgl.getExtension("WEBGL_lose_context");
  if (lost) { lost.loseContext(); }

  var scene = JSON.parse(document.getElementById("scene-data").textContent);
  var chosen = "all";
  var views = {
    corner: { eye: { x: 1.2, y: -1.6, z: 0.6 }, center: { x: 0, y: 0, z: -0.14 }, up: { x: 0, y: 0, z: 1 } },
    side: { eye: { x: 0, y: -1.75, z: 0.08 }, up: { x: 0, y: 0, z: 1 } },
    top: { eye: { x: 0, y: -0.02, z: 1.9 }, up: { x: 0, y: 1, z: 0 } }
  };

  function switchedOn(role) {
    var input = document.querySelector('input[data-role="' + role + '"]');
    return !input || input.checked;
  }

  function shown(trace) {
    var role = trace.meta.role, own = String(trace.meta.group) === chosen;
    if (role === "test" || role === "limit") { return switchedOn(role); }
    if (role === "solid") { return chosen === "all" || own; }
    if (role === "ghost") { return chosen !== "all" && !own; }
    if (role === "crowd") { return chosen === "all" && scene.count > 1; }
    return (own || scene.count === 1) && (role === "detail" || switchedOn("limit"));
  }

  function refresh() {
    Plotly.restyle(box, { visible: scene.data.map(shown) });
    document.querySelectorAll("button[data-show]").forEach(function (button) {
      button.setAttribute("aria-pressed", String(button.dataset.show === chosen));
    });
  }

  function choose(which) { chosen = which; refresh(); }

  document.getElementById("stage").hidden = false;
  var narrow = window.innerWidth < 640;
  scene.layout.scene.camera = JSON.parse(JSON.stringify(views.corner));
  if (narrow) {
    ["x", "y", "z"].forEach(function (axis) { scene.layout.scene[axis + "axis"].nticks = 4; });
    scene.layout.scene.camera.eye = { x: 1.75, y: -2.3, z: 0.9 };
    scene.data.forEach(function (trace) { if (trace.textfont) { trace.textfont.size -= 2; } });
  }
  scene.data.forEach(function (trace) { trace.visible = shown(trace); });
  Plotly.newPlot(box, scene.data, scene.layout, {
    responsive: true, displaylogo: false, displayModeBar: false
  });

  document.querySelectorAll("button[data-show]").forEach(function (button) {
    button.addEventListener("click", function () { choose(button.dataset.show); });
  });
  document.querySelectorAll("button[data-view]").forEach(function (button) {
    button.addEventListener("click", function () {
      Plotly.relayout(box, { "scene.camera": views[button.dataset.view] });
    });
  });
  document.querySelectorAll("input[data-role]").forEach(function (input) {
    input.addEventListener("change", refresh);
  });
  document.querySelectorAll("figure[data-show]").forEach(function (figure) {
    figure.setAttribute("role", "button");
    figure.setAttribute("tabindex", "0");
    figure.setAttribute("aria-label", "Show configuration " + (Number(figure.dataset.show) + 1) + " in 3D");
    function show() {
      choose(figure.dataset.show);
      document.getElementById("robot").scrollIntoView({ block: "start" });
    }
    figure.addEventListener("click", show);
    figure.addEventListener("keydown", function (event) {
      if (event.key === "Enter" || event.key === " ") { event.preventDefault(); show(); }
    });
  });

  // The wheel scrolls the page until the scene is clicked, and again once the pointer leaves it.
  var active = false;
  box.addEventListener("pointerdown", function () { active = true; });
  box.addEventListener("pointerleave", function () { active = false; });
  box.addEventListener("wheel", function (event) { if (!active) { event.stopPropagation(); } }, true);
})();
