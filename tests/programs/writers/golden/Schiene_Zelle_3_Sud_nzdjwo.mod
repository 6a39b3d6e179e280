MODULE Schiene_Zelle_3_Sud_nzdjwo
  ! Calibration campaign: 3 experiments in 2 configurations.
  ! Made by elastocal 0.1.0 from Schiene - Zelle 3 (Sud).
  ! plan sha256 0123456789abcdef
  ! Start: load every module of Schiene_Zelle_3_Sud_nzdjwo into the task that
  ! moves the robot, call Run_Schiene_Zelle_3_Sud_nzdjwo.
  ! Robot: arm on a rail. Joint values: degrees, mm, as in the model.
  ! Forces act at the load point of the tool, in the axes of the robot base.
  ! Not watched: the robot against itself, floor.
  ! SAFETY: check this program at low speed in manual mode first. Motions
  ! between the points are not checked for collisions by this file.
  ! Set the payload of the empty calibration tool and leave it so, loaded and
  ! unloaded: the controller must not compensate what is to be measured.
  ! elastocal program 000000000000
  ! Axes: rax_1 J2, rax_2 J3, rax_3 J4, rax_4 J5, rax_5 J6, rax_6 J7, eax_a S1.
  ! Replace tool0 by your tool, with its load.
  LOCAL CONST jointtarget jH0:=[[0.0000,0.0000,0.0000,0.0000,0.0000,0.0000],[0.0000,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jAP1:=[[5.2296,-11.9592,16.6887,-23.4183,28.1479,-34.8775],[1233.5679,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jP1:=[[5.7296,-11.4592,17.1887,-22.9183,28.6479,-34.3775],[1234.5679,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jAP2:=[[62.5254,68.2549,-74.9845,79.7141,-86.4437,177.1169],[499.0000,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jP2:=[[63.0254,68.7549,-74.4845,80.2141,-85.9437,177.6169],[500.0000,9E9,9E9,9E9,9E9,9E9]];
  LOCAL VAR num nAnswer:=0;

  PROC Run_Schiene_Zelle_3_Sud_nzdjwo()
    VelSet 25,1000;
    MoveAbsJ jH0\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jAP1\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP1\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 1/3: pose 1. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 1/3: apply 374.63 N, Fx 100";
    TPWrite "Fy -200.5 Fz -300.25 N.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 1/3: pose 1. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 1/3: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jAP2\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP2\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 2/3: pose 2. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 2/3: hang 10 kg, Fx 0 Fy 0 Fz";
    TPWrite "-98.07 N, Tx 1.5 Ty 0 Tz -2 N.m.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 2/3: pose 2. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 2/3: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jAP2\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP2\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 3/3: pose 2. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 3/3: hang 10 kg, Fx 0 Fy 0 Fz";
    TPWrite "-98.07 N, Tx 1.5 Ty 0 Tz -2 N.m.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 3/3: pose 2. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 3/3: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jH0\NoEOffs,v1000,fine,tool0;
    VelSet 100,5000;
  ENDPROC
ENDMODULE
