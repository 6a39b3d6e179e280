MODULE KR_270_milling_cell_f2o4si
  ! Calibration campaign: 4 experiments in 3 configurations.
  ! Made by elastocal 0.1.0 from KR 270 milling cell.
  ! plan sha256 0123456789abcdef
  ! Start: load every module of KR_270_milling_cell_f2o4si into the task that
  ! moves the robot, call Run_KR_270_milling_cell_f2o4si.
  ! Robot: kuka-kr270. Joint values: degrees, mm, as in the model.
  ! Forces act at the load point of the tool, in the axes of the robot base.
  ! No home position: the first motion starts where the robot stands.
  ! Watched for collisions: floor, the robot against itself.
  ! SAFETY: check this program at low speed in manual mode first. Motions from
  ! point to point were checked for collisions with what the study names, in
  ! this order and from home, the way to home was not.
  ! Set the payload of the empty calibration tool and leave it so, loaded and
  ! unloaded: the controller must not compensate what is to be measured.
  ! elastocal program 000000000000
  ! Axes: rax_1 A1, rax_2 A2, rax_3 A3, rax_4 A4, rax_5 A5, rax_6 A6.
  ! Replace tool0 by your tool, with its load.
  LOCAL CONST jointtarget jAP1:=[[-0.5000,-51.2922,62.5588,-32.0611,101.1598,-94.2903],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jP1:=[[0.0000,-50.7922,63.0588,-32.5611,101.6598,-93.7903],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jAP2:=[[-0.5000,-55.9571,-72.9034,-118.8938,-57.0916,-179.7668],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jP2:=[[0.0000,-55.4571,-72.4034,-119.3938,-56.5916,-179.2668],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jAP3:=[[-0.5000,-2.1852,-4.2994,-57.7496,39.0358,168.3163],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jP3:=[[0.0000,-1.6852,-3.7994,-58.2496,39.5358,168.8163],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL VAR num nAnswer:=0;

  PROC Run_KR_270_milling_cell_f2o4si()
    VelSet 10,1000;
    MoveAbsJ jAP1\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP1\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 1/4: pose 1. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 1/4: hang 254.929 kg, Fx 0 Fy";
    TPWrite "0 Fz -2500 N.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 1/4: pose 1. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 1/4: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jAP1\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP1\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 2/4: pose 1. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 2/4: hang 254.929 kg, Fx 0 Fy";
    TPWrite "0 Fz -2500 N.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 2/4: pose 1. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 2/4: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jAP2\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP2\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 3/4: pose 2. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 3/4: hang 254.929 kg, Fx 0 Fy";
    TPWrite "0 Fz -2500 N.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 3/4: pose 2. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 3/4: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jAP3\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jP3\NoEOffs,v1000,fine,tool0;
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 4/4: pose 3. NO load. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 4/4: hang 254.929 kg, Fx 0 Fy";
    TPWrite "0 Fz -2500 N.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    WaitTime \InPos,2.00;
    TPErase;
    TPWrite "Experiment 4/4: pose 3. LOADED. Measure";
    TPWrite "M1.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    TPErase;
    TPWrite "Experiment 4/4: take the load off. The";
    TPWrite "robot moves next.";
    TPReadFK nAnswer,"Done? Then go on.",stEmpty,stEmpty,stEmpty,stEmpty,"Go on";
    MoveAbsJ jAP3\NoEOffs,v1000,fine,tool0;
    VelSet 100,5000;
  ENDPROC
ENDMODULE
