"""What OpenGL takes for a depth picture of a mesh on this machine, beside the eyes' own drawing.

    python opengl_depth.py [PICTURES]        # needs numpy and moderngl; LP_NUM_THREADS=0 for one thread

Draws 61,268 small triangles, as many as the home of bench_continuous has, at random places around the eye
(SYNTHETIC) into 256 x 256 pixels through EGL, and reads the depth back. Prints the renderer and milliseconds a
picture, of the processor and of the clock. `bench_continuous --benchmark_filter=draw/depth/1` draws 64 pictures.
"""

import sys
import time

import moderngl
import numpy as np

SIZE, TRIANGLES, EYE = 256, 61_268, (0, 0, 1.25)
VERTEX = """#version 330
in vec3 point; uniform float heading; uniform vec3 eye;
void main() {
  vec3 p = point - eye;
  float right = cos(heading) * p.x - sin(heading) * p.y, ahead = sin(heading) * p.x + cos(heading) * p.y;
  gl_Position = vec4(right, p.z, 1.001 * ahead - 0.02, ahead);  // 90 degrees, near plane at 1 cm
}"""


def main(pictures: int = 100) -> None:
    context = moderngl.create_standalone_context(backend="egl")
    random = np.random.default_rng(1)
    middles = random.uniform([-8, -6, 0], [8, 6, 3], (TRIANGLES, 1, 3))
    corners = (middles + random.normal(0, 0.08, (TRIANGLES, 3, 3))).astype("f4")
    program = context.program(vertex_shader=VERTEX, fragment_shader="#version 330\nvoid main() {}")
    program["eye"].value = EYE
    mesh = context.vertex_array(program, [(context.buffer(corners.tobytes()), "3f", "point")])
    target = context.framebuffer(depth_attachment=context.depth_texture((SIZE, SIZE)))
    target.use()
    context.enable(moderngl.DEPTH_TEST)

    def draw(heading: float) -> np.ndarray:
        target.clear()
        program["heading"].value = heading
        mesh.render()
        return np.frombuffer(target.read(attachment=-1, dtype="f4"), "f4")

    seen = draw(0)  # compiles what it needs
    assert (seen < 1).mean() > 0.5, "most pixels should show a triangle"
    processor, clock = time.process_time(), time.perf_counter()
    for k in range(pictures):
        draw(2 * np.pi * k / pictures)
    processor, clock = time.process_time() - processor, time.perf_counter() - clock
    print(f"{context.info['GL_RENDERER']}: {1e3 * processor / pictures:.2f} ms of the processor, {1e3 * clock / pictures:.2f} ms")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
