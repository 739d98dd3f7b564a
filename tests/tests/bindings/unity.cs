// Stand-in of the few types of Unity's engine that PalpateTissue uses, and a press through that component with a clock of the
// test. Prints tip and force of every tick in the scene's frame, and at the end how the drawn surface moved, and the fault
// that a late tick has left.
using System;
using System.Globalization;

namespace UnityEngine {
    public struct Vector3 {
        public float x, y, z;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
    }

    public struct Quaternion {
        public float x, y, z, w;
        public Quaternion(float x, float y, float z, float w) { this.x = x; this.y = y; this.z = z; this.w = w; }
    }

    public sealed class Mesh {
        public Vector3[] vertices;
        public int[] triangles;
        public int normals;
        public void RecalculateNormals() { normals++; }
    }

    public sealed class MeshFilter { public Mesh mesh; }

    public sealed class RequireComponent : Attribute { public RequireComponent(Type type) {} }

    public class MonoBehaviour {
        private readonly MeshFilter filter = new MeshFilter();
        public T GetComponent<T>() where T : class { return filter as T; }
    }

    public static class Debug {
        public static string errors = "";
        public static void Log(object message) { Console.Error.WriteLine(message); }
        public static void LogError(object message) { errors += message; }
    }
}

static class Test {
    // Six times the volume inside the triangles: positive if the normals that Unity computes point outward.
    static double Volume(UnityEngine.Mesh mesh) {
        double sum = 0.0;
        for (int k = 0; k < mesh.triangles.Length; k += 3) {
            UnityEngine.Vector3 a = mesh.vertices[mesh.triangles[k]], b = mesh.vertices[mesh.triangles[k + 1]], c = mesh.vertices[mesh.triangles[k + 2]];
            sum += a.x * ((double)b.y * c.z - (double)b.z * c.y) + a.y * ((double)b.z * c.x - (double)b.x * c.z) + a.z * ((double)b.x * c.y - (double)b.y * c.x);
        }
        return sum;
    }

    // The node at the site: nearest to the origin before the press.
    static int Site(UnityEngine.Mesh mesh) {
        int site = 0;
        for (int n = 0; n < mesh.vertices.Length; n++) {
            UnityEngine.Vector3 v = mesh.vertices[n], s = mesh.vertices[site];
            if (v.x * v.x + v.y * v.y + v.z * v.z < s.x * s.x + s.y * s.y + s.z * s.z) site = n;
        }
        return site;
    }

    static void Main() {
        CultureInfo.CurrentCulture = CultureInfo.InvariantCulture;
        long now_us = 0;
        var tissue = new PalpateTissue { clock_us = () => now_us };
        tissue.Awake();
        UnityEngine.Mesh mesh = tissue.GetComponent<UnityEngine.MeshFilter>().mesh;
        int site = Site(mesh);
        double volume = Volume(mesh), deepest = 0.0;
        for (int tick = 0; tick < 2500; tick++, now_us += 1000) {
            int steps = tick < 700 ? 0 : Math.Min(tick - 700, 2500 - tick);
            var tip = new UnityEngine.Vector3(1e-3f, 5e-3f - 1e-5f * steps, 2e-3f);
            var upright = new UnityEngine.Quaternion(0f, 0f, 0f, 1f);
            UnityEngine.Vector3 force_n = tick % 2 == 0 ? tissue.Tick(tip) : tissue.Tick(tip, upright);
            Console.WriteLine("{0:R} {1:R} {2:R} {3:G9} {4:G9} {5:G9}", -(double)tip.z, (double)tip.x, (double)tip.y, -force_n.z, force_n.x, force_n.y);
            if (tick % 16 == 15) tissue.Update();
            deepest = Math.Min(deepest, mesh.vertices[site].y);
        }
        now_us += 5000;
        tissue.Tick(new UnityEngine.Vector3(0f, 5e-3f, 0f));
        now_us += 5000;
        UnityEngine.Vector3 last = tissue.Tick(new UnityEngine.Vector3(0f, 5e-3f, 0f));
        for (int tick = 0; tick < 16; tick++, now_us += 1000) tissue.Tick(new UnityEngine.Vector3(0f, 5e-3f, 0f));
        tissue.Update();
        string errors = UnityEngine.Debug.errors;
        int normals = mesh.normals;
        float late = last.y;
        // armed again without a new session; a request out of order, and a tilt beyond the range, are said
        Action<int, double, double> press = (ticks, from_m, step_m) => {
            for (int tick = 0; tick < ticks; tick++, now_us += 1000) last = tissue.Tick(new UnityEngine.Vector3(0f, (float)(from_m - step_m * tick), 0f));
        };
        tissue.Arm();
        press(200, 5e-3, 0.0);
        tissue.Update();
        if (!UnityEngine.Debug.errors.EndsWith("clear it before arming again")) throw new Exception(UnityEngine.Debug.errors);
        tissue.Clear();
        press(1, 5e-3, 0.0);
        tissue.Arm();
        press(800, 5e-3, 0.0);
        press(700, 5e-3, 1e-5);
        if (last.y < 0.01f) throw new Exception("no force after a fault that was cleared");
        tissue.Tick(new UnityEngine.Vector3(0f, -2e-3f, 0f), new UnityEngine.Quaternion(0.6f, 0f, 0f, 0.8f));
        tissue.Update();
        if (!UnityEngine.Debug.errors.Contains("orientation")) throw new Exception(UnityEngine.Debug.errors);
        tissue.OnDestroy();
        // a plugin may call on, and a component whose scene cannot be opened is destroyed as well
        var failed = new PalpateTissue { scene = "nowhere.toml" };
        try { failed.Awake(); } catch (Palpate.PalpateException) {}
        foreach (PalpateTissue ended in new[] { tissue, failed }) {
            for (int tick = 0; tick < 32; tick++) {
                UnityEngine.Vector3 none = ended.Tick(new UnityEngine.Vector3(0f, 5e-3f, 0f));
                if (none.x != 0f || none.y != 0f || none.z != 0f) throw new Exception("a force without a session");
            }
            ended.OnDestroy();
        }
        Console.WriteLine("end {0} {1} {2} {3} {4}", deepest, volume > 0.0, normals, late, errors);
    }
}
