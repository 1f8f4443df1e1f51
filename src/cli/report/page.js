/* Turns the hemisphere of lights. Every shape carries its points in space, as `data-p`: x,y,z triples
 * between spaces, x right, y up, z to the camera. Without this script the drawing stays as it was
 * written, seen from the turn that `data-turn` states: degrees about the vertical, then about the
 * horizontal. */
(function () {
  "use strict";
  function points(shape) {
    return shape.getAttribute("data-p").split(" ").map(function (p) {
      return p.split(",").map(Number);
    });
  }

  function setUp(dome) {
    var size = Number(dome.getAttribute("data-size"));
    var start = dome.getAttribute("data-turn").split(",").map(Number);
    var turn = start.slice();
    var shapes = Array.prototype.map.call(dome.querySelectorAll("[data-p]"), function (shape) {
      return { node: shape, points: points(shape) };
    });
    var from = null;

    /* orthographic: [x, y on the drawing, depth towards the viewer] */
    function seen(p) {
      var a = turn[0] * Math.PI / 180, b = turn[1] * Math.PI / 180;
      var x = Math.cos(a) * p[0] + Math.sin(a) * p[2];
      var z = -Math.sin(a) * p[0] + Math.cos(a) * p[2];
      var y = Math.cos(b) * p[1] - Math.sin(b) * z;
      return [size * x, -size * y, Math.sin(b) * p[1] + Math.cos(b) * z];
    }

    function draw() {
      shapes.forEach(function (shape) {
        var at = shape.points.map(seen), node = shape.node, first = at[0];
        if (node.tagName === "circle") {
          node.setAttribute("cx", first[0].toFixed(1));
          node.setAttribute("cy", first[1].toFixed(1));
          node.classList.toggle("behind", first[2] < 0);
        } else if (node.tagName === "text") {
          node.setAttribute("x", first[0].toFixed(1));
          node.setAttribute("y", first[1].toFixed(1));
        } else {
          node.setAttribute("points", at.map(function (p) {
            return p[0].toFixed(1) + "," + p[1].toFixed(1);
          }).join(" "));
        }
      });
      dome.setAttribute("data-turn", turn.map(Math.round).join(","));
    }

    function turnBy(x, y) {
      turn = [(turn[0] + x) % 360, Math.max(-90, Math.min(90, turn[1] + y))];
      draw();
    }

    dome.addEventListener("pointerdown", function (event) {
      from = [event.clientX, event.clientY];
      dome.setPointerCapture(event.pointerId);
    });
    dome.addEventListener("pointermove", function (event) {
      if (!from) return;
      turnBy((event.clientX - from[0]) / 2, (event.clientY - from[1]) / 2);
      from = [event.clientX, event.clientY];
    });
    ["pointerup", "pointercancel"].forEach(function (name) {
      dome.addEventListener(name, function () { from = null; });
    });
    dome.addEventListener("keydown", function (event) {
      var by = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, -10], ArrowDown: [0, 10] }[event.key];
      if (!by) return;
      event.preventDefault();
      turnBy(by[0], by[1]);
    });
    Array.prototype.forEach.call(dome.parentNode.querySelectorAll("[data-view]"), function (button) {
      button.addEventListener("click", function () {
        var view = button.getAttribute("data-view");
        turn = view === "" ? start.slice() : view.split(",").map(Number);
        draw();
      });
    });
  }

  Array.prototype.forEach.call(document.querySelectorAll("svg.dome"), setUp);
})();
