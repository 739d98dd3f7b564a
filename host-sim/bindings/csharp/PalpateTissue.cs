// A soft tissue as a Unity component; UNTESTED IN UNITY: it compiles and runs against our stand-in of the engine's types.
// Add it to an object with a MeshFilter and a MeshRenderer, and call Tick from your device plugin's callback, which runs
// a thousand times per second in a thread of its own. Positions are those of the object: metres; x right, y up, z away from
// the operator; the origin is the site of the press.
using System;
using System.Diagnostics;
using System.Threading;
using Palpate;
using UnityEngine;

[RequireComponent(typeof(MeshFilter))]
public sealed class PalpateTissue : MonoBehaviour {
    public string scene = "block";
    public string device = "touch";

    // Clock of the ticks [us]; a test has one of its own.
    public Func<long> clock_us = () => Stopwatch.GetTimestamp() * 1000000 / Stopwatch.Frequency;

    private const int TicksPerCopy = 16; // a frame at 60 Hz
    private volatile Session session; // assigned last: the device's thread may call Tick at any time
    private Action<Session> asked;
    private string refused;
    private readonly double[] orientation = new double[4];
    private Info info;
    private double[] nodes_m;
    private Vector3[] vertices;
    private Mesh mesh;
    private bool changed;
    private long due_us = -1;
    private int ticks;
    private volatile int fault;
    private int told;

    // The scene may take seconds to open. The force begins when the tip has been outside and calm.
    public void Awake() {
        Session opened = Session.Open(scene, null, device);
        info = opened.Info;
        nodes_m = new double[3 * (int)info.nodes];
        vertices = new Vector3[(int)info.nodes];
        mesh = new Mesh();
        opened.ReadNodes(nodes_m);
        changed = true;
        Update();
        int[] corners = Array.ConvertAll(opened.Triangles, corner => (int)corner);
        Array.Reverse(corners); // Unity draws triangles that run clockwise seen from outside
        mesh.triangles = corners;
        GetComponent<MeshFilter>().mesh = mesh;
        UnityEngine.Debug.Log(opened.Cautions);
        opened.Arm();
        session = opened;
    }

    // Requests that the next tick passes on, from any thread. After a fault: Clear, then Arm a moment later.
    public void Arm() { Interlocked.Exchange(ref asked, s => s.Arm()); }

    public void Stop() { Interlocked.Exchange(ref asked, s => s.Stop()); }

    public void Clear() { Interlocked.Exchange(ref asked, s => s.Clear()); }

    // The same for a probe that turns with the device: its rotation from the upright pose, by at most 45 degrees.
    public Vector3 Tick(Vector3 tip, Quaternion rotation) {
        orientation[0] = rotation.z; // a left-handed frame turns the other way
        orientation[1] = -rotation.x;
        orientation[2] = -rotation.y;
        orientation[3] = rotation.w;
        Session turned = session;
        if (turned != null) Try(turned, Turned);
        return Tick(tip);
    }

    // One tick: the tip's position in, the force on the device out [N]; zero on a fault, and without a session.
    public Vector3 Tick(Vector3 tip) {
        Session session = this.session;
        if (session == null) return new Vector3(0f, 0f, 0f);
        Try(session, Interlocked.Exchange(ref asked, null));
        var input = new Palpate.Input { tip_m = ToScene(tip), late_ticks = LateTicks() };
        input.tip_m.x += info.site_m.x;
        input.tip_m.y += info.site_m.y;
        input.tip_m.z += info.site_m.z;
        Vector force_n;
        Code code = session.Tick(ref input, out force_n);
        if (code == Code.Fault) fault = session.Report.fault;
        // copied in this thread, because a session answers one thread at a time; a tick never waits for a frame
        bool open = code == Code.Ok || code == Code.Fault;
        if (++ticks % TicksPerCopy == 0 && open && Monitor.TryEnter(nodes_m)) {
            session.ReadNodes(nodes_m);
            changed = true;
            Monitor.Exit(nodes_m);
        }
        return ToUnity(force_n.x, force_n.y, force_n.z);
    }

    // Draws the last copy.
    public void Update() {
        lock (nodes_m) {
            if (!changed) return;
            for (int n = 0; n < vertices.Length; n++)
                vertices[n] = ToUnity(nodes_m[3 * n] - info.site_m.x, nodes_m[3 * n + 1] - info.site_m.y, nodes_m[3 * n + 2] - info.site_m.z);
            changed = false;
        }
        mesh.vertices = vertices;
        mesh.RecalculateNormals();
        if (fault != told) UnityEngine.Debug.LogError("palpate: " + Session.FaultText(fault));
        told = fault;
        string why = Interlocked.Exchange(ref refused, null);
        if (why != null) UnityEngine.Debug.LogError("palpate: " + why);
    }

    // Stop your device first: it keeps the last force that it was given.
    public void OnDestroy() {
        if (session != null) session.Dispose();
    }

    private void Turned(Session session) { session.Turn(orientation); }

    private void Try(Session session, Action<Session> call) {
        if (call == null) return;
        try { call(session); } catch (PalpateException error) { refused = error.Message; }
    }

    // Milliseconds that passed without a tick; a driver may run a little faster than 1 kHz.
    private uint LateTicks() {
        long now_us = clock_us();
        if (due_us < 0) due_us = now_us - 1000;
        due_us = Math.Min(due_us + 1000, now_us);
        long late = (now_us - due_us) / 1000;
        due_us += 1000 * late;
        return (uint)late;
    }

    private static Vector ToScene(Vector3 v) { return new Vector(-v.z, v.x, v.y); }

    private static Vector3 ToUnity(double x, double y, double z) { return new Vector3((float)y, (float)z, (float)-x); }
}
