(function () {
  "use strict";
  var printer = document.getElementById("print");
  if (printer) {
    printer.hidden = false;
    printer.addEventListener("click", function () { window.print(); });
  }

  function drawable() {
    var canvas = document.createElement("canvas");
    var webgl = canvas.getContext("webgl2") || canvas.getContext("webgl");
    if (!webgl || typeof Plotly === "undefined") { return false; }
    var lost = webgl.getExtension("WEBGL_lose_context");
    if (lost) { lost.loseContext(); }
    return true;
  }

  var views = {
    corner: { eye: { x: 1.2, y: -1.6, z: 0.6 }, center: { x: 0, y: 0, z: -0.14 }, up: { x: 0, y: 0, z: 1 } },
    side: { eye: { x: 0, y: -1.75, z: 0.08 }, up: { x: 0, y: 0, z: 1 } },
    top: { eye: { x: 0, y: -0.02, z: 1.9 }, up: { x: 0, y: 1, z: 0 } }
  };

  function fitToPhone(scene) {
    ["x", "y", "z"].forEach(function (axis) { scene.layout.scene[axis + "axis"].nticks = 4; });
    scene.layout.scene.camera.eye = { x: 1.75, y: -2.3, z: 0.9 };
    scene.data.forEach(function (trace) { if (trace.textfont) { trace.textfont.size -= 2; } });
  }

  function show(stage) {
    var card = stage.closest(".card"), box = stage.querySelector(".scene");
    var scene = JSON.parse(document.getElementById(stage.dataset.scene).textContent);
    var chosen = "all", alone = false;

    // A role with a switch of its own goes by that; the others by the chosen configuration.
    function switchedOn(role) {
      var input = card.querySelector('input[data-role="' + role + '"]');
      return !input || input.checked;
    }

    function shown(trace) {
      var role = trace.meta.role, own = String(trace.meta.group) === chosen;
      if (alone && trace.meta.group >= 0) { return false; }
      if (role === "solid") { return chosen === "all" || own; }
      if (role === "ghost") { return chosen !== "all" && !own; }
      if (role === "crowd") { return chosen === "all" && scene.count > 1; }
      if (role === "detail" || role === "limit-detail") {
        return (own || scene.count === 1) && (role === "detail" || switchedOn("limit"));
      }
      return switchedOn(role);
    }

    function refresh() {
      Plotly.restyle(box, { visible: scene.data.map(shown) });
      card.querySelectorAll("button[data-show]").forEach(function (button) {
        button.setAttribute("aria-pressed", String(button.dataset.show === chosen));
      });
    }

    function choose(which) { chosen = which; refresh(); }

    var ranges = ["x", "y", "z"].map(function (axis) { return scene.layout.scene[axis + "axis"].range.slice(); });
    stage.hidden = false;
    scene.layout.scene.camera = JSON.parse(JSON.stringify(views.corner));
    if (window.innerWidth < 640) { fitToPhone(scene); }
    scene.data.forEach(function (trace) { trace.visible = shown(trace); });
    Plotly.newPlot(box, scene.data, scene.layout, {
      responsive: true, displaylogo: false, displayModeBar: false
    });

    card.querySelectorAll("button[data-show]").forEach(function (button) {
      button.addEventListener("click", function () { choose(button.dataset.show); });
    });
    card.querySelectorAll("button[data-view]").forEach(function (button) {
      button.addEventListener("click", function () {
        var near = button.dataset.view === "near";
        var change = { "scene.camera": views[near ? "corner" : button.dataset.view] };
        ["x", "y", "z"].forEach(function (axis, i) {
          if (scene.near) { change["scene." + axis + "axis.range"] = near ? scene.near[i] : ranges[i]; }
        });
        alone = near;
        refresh();
        Plotly.relayout(box, change);
      });
    });
    card.querySelectorAll("input[data-role]").forEach(function (input) {
      input.addEventListener("change", refresh);
    });
    card.querySelectorAll("figure[data-show]").forEach(function (figure) {
      figure.setAttribute("role", "button");
      figure.setAttribute("tabindex", "0");
      figure.setAttribute("aria-label", "Show configuration " + (Number(figure.dataset.show) + 1) + " in 3D");
      function pick() {
        choose(figure.dataset.show);
        card.scrollIntoView({ block: "start" });
      }
      figure.addEventListener("click", pick);
      figure.addEventListener("keydown", function (event) {
        if (event.key === "Enter" || event.key === " ") { event.preventDefault(); pick(); }
      });
    });

    // The wheel scrolls the page until the scene is clicked, and again once the pointer leaves it.
    var active = false;
    box.addEventListener("pointerdown", function () { active = true; });
    box.addEventListener("pointerleave", function () { active = false; });
    box.addEventListener("wheel", function (event) { if (!active) { event.stopPropagation(); } }, true);
  }

  var stages = document.querySelectorAll(".stage[data-scene]");
  if (!stages.length) { return; }
  if (!drawable()) {
    document.querySelectorAll(".scene-note").forEach(function (note) {
      note.textContent = "This device shows no 3D graphics; here is the same as pictures.";
    });
    return;
  }
  stages.forEach(show);
})();
